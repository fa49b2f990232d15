/* HX711 converters as their data sheet describes them, for tests without a board. */
#ifndef SHOE_CONVERTERS_H
#define SHOE_CONVERTERS_H

#include <stdbool.h>
#include <stdint.h>

#define CONVERTERS 8

/* What the program's words say of each converter: a number of counts, to which 0 to 15 are added in
   turn; `dead`: never ready; `short`: its data line lies at ground. Others are dead.
   False for a word that is none of these. */
bool converters_begin(int words, char **word, double rate_hz);

/* Levels of the data lines. */
uint8_t converters_data(uint64_t now_us);

/* The clock line changes to this level. */
void converters_clock(bool level, uint64_t now_us);

#endif
