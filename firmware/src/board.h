/* What a board of the shoe is: its channels, and what the rest of the firmware asks of it. */
#ifndef SHOE_BOARD_H
#define SHOE_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#ifndef CHANNELS
#define CHANNELS 8 /* converters, 1 to 8 */
#endif
#ifndef FIRST_CHANNEL
#define FIRST_CHANNEL 0 /* index of the first one: a second board goes on where this one ends */
#endif
#ifndef RATE_HZ
#define RATE_HZ 80 /* of an HX711 with RATE high; 10 with RATE low */
#endif
#ifndef FIRMWARE
#define FIRMWARE "shoecal-hx711 1.0" /* at most 64 bytes */
#endif

#define ALL_CHANNELS ((uint8_t)((1u << CHANNELS) - 1u))

/* Time since start [us]; never wraps. */
uint64_t board_time_us(void);

/* Levels of the converters' data lines, bit k for channel k. */
uint8_t board_data(void);

/* One pulse on the clock line of all converters: up for 1 to 50 us, whatever else happens, then
   down. The data lines' levels just before the fall. */
uint8_t board_pulse(void);

/* Clock line up for long enough (60 us) that converters switch off, then down: all begin anew, and
   at the same time. */
void board_restart_converters(void);

/* Put bytes on the line, all of them or none; whether they were taken. Never waits. */
bool board_send(const uint8_t *bytes, uint8_t count);

/* Next byte received, or -1. */
int16_t board_receive(void);

/* Nothing to do at the moment. */
void board_idle(void);

#endif
