#include "request.h"

/* The bytes of docs/reference/protocol.md, delimiter before and after. */
static const uint8_t REQUEST[] = {0x00, 0x07, 0x01, 0x03, 0x04, 0x72, 0xcb, 0xc1, 0x00};

static uint8_t matched;

bool request_heard(uint8_t byte) {
  if (byte != REQUEST[matched]) {
    /* Zeros stand at the ends alone, so only a zero can begin a request anew. */
    matched = byte == REQUEST[0];
    return false;
  }
  if (++matched < sizeof REQUEST) return false;
  matched = 1; /* this delimiter may be the next request's first */
  return true;
}
