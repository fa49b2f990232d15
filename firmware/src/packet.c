#include "packet.h"

enum type { TYPE_FRAME = 1, TYPE_INFO = 2 };

static uint8_t *put(uint8_t *place, uint64_t value, uint8_t bytes) {
  for (; bytes > 0; bytes--, value >>= 8) *place++ = (uint8_t)value;
  return place;
}

static uint32_t crc32(const uint8_t *begin, const uint8_t *end) {
  uint32_t crc = 0xFFFFFFFFu;
  for (; begin < end; begin++) {
    crc ^= *begin;
    for (uint8_t bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (crc & 1u ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

/* A packet stands in out[1] up to end: add its CRC, take its zeros out in place, delimit it. */
static uint8_t seal(uint8_t *out, uint8_t *end) {
  end = put(end, crc32(out + 1, end), 4);
  uint8_t *code = out; /* where the distance to the next zero goes */
  for (uint8_t *place = out + 1; place < end; place++) {
    if (*place != 0) continue;
    *code = (uint8_t)(place - code);
    code = place;
  }
  *code = (uint8_t)(end - code);
  *end = 0;
  return (uint8_t)(end + 1 - out);
}

uint8_t packet_frame(uint8_t *out, uint32_t sequence, uint64_t time_us, int16_t centi_degc,
                     const struct reading *readings, uint8_t count) {
  uint8_t *end = put(out + 1, PROTOCOL_VERSION, 1);
  end = put(end, TYPE_FRAME, 1);
  end = put(end, sequence, 4);
  end = put(end, time_us, 8);
  end = put(end, (uint16_t)centi_degc, 2);
  end = put(end, count, 1);
  for (; count > 0; count--, readings++) {
    end = put(end, readings->index, 1);
    end = put(end, readings->status, 1);
    end = put(end, (uint32_t)readings->counts, 4);
  }
  return seal(out, end);
}

uint8_t packet_info(uint8_t *out, uint8_t channels, uint32_t rate_mhz, const char *name) {
  uint8_t *end = put(out + 1, PROTOCOL_VERSION, 1);
  end = put(end, TYPE_INFO, 1);
  end = put(end, channels, 1);
  end = put(end, rate_mhz, 4);
  for (; *name != '\0'; name++) *end++ = (uint8_t)*name;
  return seal(out, end);
}
