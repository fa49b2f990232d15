#include "shoe.h"

void board_begin(void);

int main(void) {
  board_begin();
  shoe_begin();
  for (;;) shoe_step();
}
