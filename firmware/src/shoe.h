/* The shoe's firmware: sample, send, answer. */
#ifndef SHOE_SHOE_H
#define SHOE_SHOE_H

/* Once, when the board is ready. */
void shoe_begin(void);

/* Again and again. */
void shoe_step(void);

#endif
