#include "shoe.h"

#include "board.h"
#include "hx711.h"
#include "packet.h"
#include "request.h"

/* Converters have clocks of their own: the slowest is waited for, but not for ever. */
#define PATIENCE_US (1500000u / RATE_HZ)
/* Samplings without data after which a converter is waited for no more, until it has some. */
#define MISSES 8

static uint32_t sequence;
static uint64_t begun_us; /* the wait for this sampling */
static uint8_t awaited = ALL_CHANNELS;
static uint8_t misses[CHANNELS];
static bool info_owed;

/* Whoever gave nothing for long holds the others up no more. */
static void judge(const struct reading readings[CHANNELS]) {
  awaited = 0;
  for (uint8_t k = 0; k < CHANNELS; k++) {
    bool missed = readings[k].status == NO_DATA || readings[k].status == FAULT;
    if (!missed) misses[k] = 0;
    if (missed && misses[k] < MISSES) misses[k]++;
    if (misses[k] < MISSES) awaited |= (uint8_t)(1u << k);
  }
}

static void send_info(void) {
  uint8_t bytes[INFO_BYTES(sizeof FIRMWARE - 1)];
  uint8_t count = packet_info(bytes, CHANNELS, 1000uL * RATE_HZ, FIRMWARE);
  info_owed = !board_send(bytes, count);
}

static void send_frame(uint64_t time_us, uint8_t ready) {
  struct reading readings[CHANNELS];
  uint8_t bytes[FRAME_BYTES(CHANNELS)];
  hx711_read(readings, ready);
  judge(readings);
  uint8_t count = packet_frame(bytes, sequence++, time_us, NO_TEMPERATURE, readings, CHANNELS);
  board_send(bytes, count); /* a full line costs this frame: the next one is newer */
}

void shoe_begin(void) {
  static const uint8_t delimiter = 0;
  board_restart_converters();
  begun_us = board_time_us();
  board_send(&delimiter, 1); /* ends what noise has put on the line */
  info_owed = true;
}

void shoe_step(void) {
  for (int16_t byte = board_receive(); byte >= 0; byte = board_receive()) {
    if (request_heard((uint8_t)byte)) info_owed = true;
  }
  if (info_owed) send_info();
  uint8_t ready = hx711_ready();
  uint64_t now_us = board_time_us();
  bool complete = awaited != 0 && (ready & awaited) == awaited;
  if (complete || now_us - begun_us > PATIENCE_US) {
    begun_us = now_us;
    send_frame(now_us, ready);
  } else {
    board_idle();
  }
}
