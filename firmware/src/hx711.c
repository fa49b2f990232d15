#include "hx711.h"

#define BITS 24
#define HIGHEST 0x7FFFFFL
#define LOWEST (-0x800000L)

uint8_t hx711_ready(void) { return (uint8_t)~board_data() & ALL_CHANNELS; }

void hx711_read(struct reading readings[CHANNELS], uint8_t ready) {
  uint8_t rows[BITS];
  for (uint8_t bit = 0; bit < BITS; bit++) rows[bit] = board_pulse();
  /* The 25th pulse chooses channel A at gain 128; a converter that is alive lets go of its data
     line then, until its next conversion. */
  board_pulse();
  uint8_t stuck = (uint8_t)~board_data();
  for (uint8_t k = 0; k < CHANNELS; k++) {
    uint8_t mask = (uint8_t)(1u << k);
    uint32_t bits = rows[0] & mask ? 0xFFu : 0u; /* the sign, extended */
    for (uint8_t bit = 0; bit < BITS; bit++) bits = (bits << 1) | (rows[bit] & mask ? 1u : 0u);
    int32_t counts = (int32_t)bits;
    readings[k].index = (uint8_t)(FIRST_CHANNEL + k);
    readings[k].counts = counts;
    readings[k].status = counts == HIGHEST || counts == LOWEST ? SATURATED : GOOD;
    if (!(ready & mask) || (stuck & mask)) {
      readings[k].status = ready & mask ? FAULT : NO_DATA;
      readings[k].counts = 0;
    }
  }
}
