#include "converters.h"

#include <stdlib.h>
#include <string.h>

#define BITS 24
#define POWER_DOWN_US 60
#define SETTLING 4 /* conversions after power-up until the first result */

enum kind { DEAD, SHORTED, ALIVE };

struct converter {
  enum kind kind;
  long base;
  double period_us;
  double done_us;  /* end of the present conversion */
  unsigned number; /* conversions so far */
  uint32_t result;
  bool ready;
  int pulses; /* of this read-out */
};

static struct converter converters[CONVERTERS];
static bool clock_level;
static uint64_t risen_us;

bool converters_begin(int words, char **word, double rate_hz) {
  for (int k = 0; k < words && k < CONVERTERS; k++) {
    struct converter *one = &converters[k];
    char *rest;
    one->base = strtol(word[k], &rest, 10);
    if (rest != word[k] && *rest == '\0') {
      one->kind = ALIVE;
    } else if (strcmp(word[k], "short") == 0) {
      one->kind = SHORTED;
    } else if (strcmp(word[k], "dead") != 0) {
      return false;
    }
    /* Each has an oscillator of its own. */
    one->period_us = 1e6 / rate_hz * (1.0 + 0.002 * (k - 3));
    one->done_us = SETTLING * one->period_us;
  }
  return true;
}

static void convert(struct converter *one, uint64_t now_us) {
  while (one->kind == ALIVE && (double)now_us >= one->done_us) {
    long counts = one->base + (long)(one->number++ & 15u);
    if (counts > 0x7FFFFFL) counts = 0x7FFFFFL;
    if (counts < -0x800000L) counts = -0x800000L;
    one->done_us += one->period_us;
    if (one->pulses > 0 && one->pulses < BITS) continue; /* it is being read */
    one->result = (uint32_t)counts & 0xFFFFFFu;
    one->ready = true;
    one->pulses = 0;
  }
}

static bool level_of(const struct converter *one) {
  if (one->kind == SHORTED) return false;
  if (one->kind == DEAD || !one->ready) return true;
  if (one->pulses == 0) return false;
  if (one->pulses > BITS) return true;
  return one->result >> (BITS - one->pulses) & 1u;
}

uint8_t converters_data(uint64_t now_us) {
  uint8_t levels = 0;
  for (int k = 0; k < CONVERTERS; k++) {
    convert(&converters[k], now_us);
    if (level_of(&converters[k])) levels |= (uint8_t)(1u << k);
  }
  return levels;
}

void converters_clock(bool level, uint64_t now_us) {
  if (level == clock_level) return;
  clock_level = level;
  if (level) {
    risen_us = now_us;
  }
  for (int k = 0; k < CONVERTERS; k++) {
    struct converter *one = &converters[k];
    convert(one, now_us);
    if (!level && now_us - risen_us > POWER_DOWN_US) {
      one->ready = false;
      one->pulses = 0;
      one->done_us = (double)now_us + SETTLING * one->period_us;
    } else if (level && one->ready && ++one->pulses > BITS) {
      one->ready = false;
      one->pulses = 0;
    }
  }
}
