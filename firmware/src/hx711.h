/* HX711 converters that share one clock line. */
#ifndef SHOE_HX711_H
#define SHOE_HX711_H

#include "board.h"
#include "packet.h"

/* Channels that have a conversion to fetch, bit k for channel k. */
uint8_t hx711_ready(void);

/* Fetch all conversions at once and begin the next ones (channel A, gain 128).
   ready: channels that had one; the others get NO_DATA. */
void hx711_read(struct reading readings[CHANNELS], uint8_t ready);

#endif
