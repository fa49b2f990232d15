/* ATmega328P, as on the Arduino Uno and Nano: data lines of channels 0 to 7 on the pins D2 to D9,
   the converters' clock on D10, the serial line on D0 and D1 (USB). */
#include "board.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>
#include <util/delay.h>
#include <util/setbaud.h>

#define CLOCK_BIT (1u << PB2)
#define TICKS_PER_US (F_CPU / 8 / 1000000)
#define POWER_DOWN_US 80

/* Indices run over the whole byte: a ring of 256 needs no bounds. */
static uint8_t sending[256], received[256];
static volatile uint8_t send_head, send_tail, receive_head, receive_tail;
static volatile uint64_t overflows;

void board_begin(void);

void board_begin(void) {
  PORTD |= 0xFCu; /* pull-ups: a line that nobody drives is never ready */
  PORTB |= 0x03u;
  DDRB |= CLOCK_BIT;
  TCCR1B = 1u << CS11; /* timer 1 counts eighths of the clock */
  TIMSK1 = 1u << TOIE1;
#if USE_2X
  UCSR0A = 1u << U2X0;
#else
  UCSR0A = 0;
#endif
  UBRR0 = UBRR_VALUE;
  UCSR0B = 1u << RXCIE0 | 1u << RXEN0 | 1u << TXEN0;
  sei();
}

ISR(TIMER1_OVF_vect) { overflows++; }

ISR(USART_RX_vect) { received[receive_head++] = UDR0; }

ISR(USART_UDRE_vect) {
  if (send_tail == send_head) {
    UCSR0B &= (uint8_t) ~(1u << UDRIE0);
  } else {
    UDR0 = sending[send_tail++];
  }
}

uint64_t board_time_us(void) {
  uint64_t high;
  uint16_t low;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    high = overflows;
    low = TCNT1;
    /* An overflow that waits for its interrupt happened before this count was read. */
    if ((TIFR1 & (1u << TOV1)) && low < 0x8000u) high++;
  }
  return (high << 16 | low) / TICKS_PER_US;
}

uint8_t board_data(void) { return (uint8_t)((PIND >> 2) | (PINB << 6)); }

uint8_t board_pulse(void) {
  uint8_t data;
  /* A clock line that stays up for 60 us switches the converters off. */
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    PORTB |= CLOCK_BIT;
    _delay_us(1);
    data = board_data();
    PORTB &= (uint8_t)~CLOCK_BIT;
  }
  _delay_us(1);
  return data;
}

void board_restart_converters(void) {
  PORTB |= CLOCK_BIT;
  _delay_us(POWER_DOWN_US);
  PORTB &= (uint8_t)~CLOCK_BIT;
}

bool board_send(const uint8_t *bytes, uint8_t count) {
  uint8_t head = send_head;
  uint8_t taken = (uint8_t)(head - send_tail);
  if (255u - taken < count) return false;
  while (count-- > 0) sending[head++] = *bytes++;
  send_head = head;
  UCSR0B |= 1u << UDRIE0;
  return true;
}

int16_t board_receive(void) {
  if (receive_tail == receive_head) return -1;
  return received[receive_tail++];
}

void board_idle(void) {}
