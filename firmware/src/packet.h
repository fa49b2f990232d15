/* Packets of docs/reference/protocol.md: layout, CRC-32, stuffing. */
#ifndef SHOE_PACKET_H
#define SHOE_PACKET_H

#include <stdint.h>

#ifndef PROTOCOL_VERSION
#define PROTOCOL_VERSION 1
#endif

enum status { GOOD = 0, SATURATED = 1, NO_DATA = 2, FAULT = 3 };

#define NO_TEMPERATURE (-32768)

/* One channel of a frame. */
struct reading {
  uint8_t index;
  uint8_t status;
  int32_t counts;
};

/* Bytes on the wire, delimiter included. */
#define FRAME_BYTES(channels) (23 + 6 * (channels))
#define INFO_BYTES(name_bytes) (13 + (name_bytes))

/* A frame of count channels into out, which has FRAME_BYTES(count); returns how many bytes. */
uint8_t packet_frame(uint8_t *out, uint32_t sequence, uint64_t time_us, int16_t centi_degc,
                     const struct reading *readings, uint8_t count);

/* An info into out, which has INFO_BYTES(strlen(name)); returns how many bytes. */
uint8_t packet_info(uint8_t *out, uint8_t channels, uint32_t rate_mhz, const char *name);

#endif
