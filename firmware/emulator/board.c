/* The firmware's own machine code on an emulated ATmega328P (simavr), its converters emulated too.
   The serial line is standard input and output; time runs as the emulated clock counts it, never
   faster than real time. */
#define _POSIX_C_SOURCE 200809L
#include <fcntl.h>
#include <poll.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_time.h>
#include <stdbool.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

#include "converters.h"

#define CLOCK_HZ 16000000uL
#define LOOK_US 20    /* between two looks at the converters */
#define PACE_US 2000  /* between two looks at the real clock */
#define LISTENER_MS 1000
#define RATE_HZ 80.0

static avr_t *avr;
static avr_irq_t *data_line[CONVERTERS];
static avr_irq_t *serial_in;
static bool line_free = true;
static struct timespec start;

static uint64_t now_us(void) { return avr->cycle * 1000000uL / CLOCK_HZ; }

static void drive_data_lines(void) {
  /* Every time anew: simavr lets pull-ups win whenever the firmware writes to the port. */
  uint8_t levels = converters_data(now_us());
  for (int k = 0; k < CONVERTERS; k++) avr_raise_irq(data_line[k], levels >> k & 1);
}

static void on_clock_line(struct avr_irq_t *irq, uint32_t level, void *param) {
  (void)irq, (void)param;
  converters_clock(level != 0, now_us());
  drive_data_lines();
}

static void on_sent(struct avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq, (void)param;
  uint8_t byte = (uint8_t)value;
  struct pollfd line = {STDOUT_FILENO, POLLOUT, 0};
  poll(&line, 1, LISTENER_MS); /* a slow listener slows the emulation, not the protocol */
  ssize_t count = write(STDOUT_FILENO, &byte, 1);
  (void)count; /* nobody there: the byte is lost, as on a real line */
}

static void on_line_free(struct avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq, (void)value, (void)param;
  line_free = true;
}

static void on_line_full(struct avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq, (void)value, (void)param;
  line_free = false;
}

static avr_cycle_count_t look(avr_t *emulated, avr_cycle_count_t when, void *param) {
  (void)emulated, (void)param;
  drive_data_lines();
  return when + avr_usec_to_cycles(avr, LOOK_US);
}

static avr_cycle_count_t pace(avr_t *emulated, avr_cycle_count_t when, void *param) {
  (void)emulated, (void)param;
  struct timespec due = start;
  uint64_t us = now_us();
  due.tv_sec += (time_t)(us / 1000000);
  due.tv_nsec += (long)(us % 1000000) * 1000;
  if (due.tv_nsec >= 1000000000L) due.tv_sec++, due.tv_nsec -= 1000000000L;
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
  for (uint8_t byte; line_free && read(STDIN_FILENO, &byte, 1) == 1;) {
    avr_raise_irq(serial_in, byte);
  }
  return when + avr_usec_to_cycles(avr, PACE_US);
}

static void never_sleep(avr_t *emulated, avr_cycle_count_t how_long) {
  (void)emulated, (void)how_long;
}

static void connect_board(void) {
  for (int k = 0; k < CONVERTERS; k++) {
    int pin = k + 2; /* D2 to D9: six pins of port D, two of port B */
    data_line[k] = pin < 8 ? avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), pin)
                           : avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), pin - 8);
  }
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), 2), on_clock_line,
                          NULL);
  uint32_t flags = 0; /* by default simavr prints what is sent */
  avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
  flags &= ~(uint32_t)(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  serial_in = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_sent,
                          NULL);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON),
                          on_line_free, NULL);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF),
                          on_line_full, NULL);
  avr_cycle_timer_register_usec(avr, LOOK_US, look, NULL);
  avr_cycle_timer_register_usec(avr, PACE_US, pace, NULL);
}

int main(int words, char **word) {
  elf_firmware_t firmware = {0};
  if (words < 2 || !converters_begin(words - 2, word + 2, RATE_HZ)) {
    fprintf(stderr, "usage: %s FIRMWARE.elf [COUNTS|dead|short]...\n", word[0]);
    return 2;
  }
  avr = avr_make_mcu_by_name("atmega328p");
  if (avr == NULL || elf_read_firmware(word[1], &firmware) != 0) {
    fprintf(stderr, "%s: cannot be loaded\n", word[1]);
    return 1;
  }
  avr_init(avr);
  avr->frequency = CLOCK_HZ;
  avr->log = LOG_ERROR;
  firmware.frequency = CLOCK_HZ;
  avr_load_firmware(avr, &firmware);
  avr->sleep = never_sleep;
  connect_board();
  fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
  fcntl(STDOUT_FILENO, F_SETFL, O_NONBLOCK);
  clock_gettime(CLOCK_MONOTONIC, &start);
  int state = cpu_Running;
  for (pid_t parent = getppid(); state != cpu_Done && state != cpu_Crashed;) {
    if ((avr->cycle & 0xFFFF) == 0 && getppid() != parent) return 0;
    state = avr_run(avr);
  }
  return state == cpu_Crashed;
}
