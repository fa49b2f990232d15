/* The firmware on this computer, with converters that are not there: the serial line is standard
   input and output. For tests: framing, converters and time are the board's own code. */
#define _POSIX_C_SOURCE 200809L
#include "board.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "converters.h"
#include "shoe.h"

static uint8_t sending[256];
static size_t unsent;
static struct timespec start;

static void flush_line(void) {
  ssize_t count = unsent > 0 ? write(STDOUT_FILENO, sending, unsent) : 0;
  if (count < 0 && errno != EAGAIN && errno != EIO) _exit(0);
  if (count <= 0) return;
  unsent -= (size_t)count;
  memmove(sending, sending + count, unsent);
}

static uint64_t since_start_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)((now.tv_sec - start.tv_sec) * 1000000L + (now.tv_nsec - start.tv_nsec) / 1000);
}

uint64_t board_time_us(void) { return since_start_us(); }

uint8_t board_data(void) { return converters_data(since_start_us()); }

uint8_t board_pulse(void) {
  /* A computer may be held up in between, a converter's clock line must not be. */
  uint64_t now_us = since_start_us();
  converters_clock(true, now_us);
  uint8_t data = converters_data(now_us);
  converters_clock(false, now_us + 1);
  return data;
}

void board_restart_converters(void) {
  uint64_t now_us = since_start_us();
  converters_clock(true, now_us);
  converters_clock(false, now_us + 80);
}

bool board_send(const uint8_t *bytes, uint8_t count) {
  flush_line();
  if (sizeof sending - unsent < count) return false;
  memcpy(sending + unsent, bytes, count);
  unsent += count;
  flush_line();
  return true;
}

int16_t board_receive(void) {
  uint8_t byte;
  ssize_t count = read(STDIN_FILENO, &byte, 1);
  return count == 1 ? byte : -1;
}

void board_idle(void) {
  struct timespec pause = {0, 200000};
  flush_line();
  nanosleep(&pause, NULL);
}

int main(int words, char **word) {
  if (!converters_begin(words - 1, word + 1, RATE_HZ)) {
    fprintf(stderr, "usage: %s [COUNTS|dead|short]...  one word a converter\n", word[0]);
    return 2;
  }
  fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
  fcntl(STDOUT_FILENO, F_SETFL, O_NONBLOCK);
  clock_gettime(CLOCK_MONOTONIC, &start);
  shoe_begin();
  /* The parent that dies takes its end of the line with it. */
  for (pid_t parent = getppid(); getppid() == parent;) shoe_step();
  return 0;
}
