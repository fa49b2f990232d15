/* The driver's question what this device is. */
#ifndef SHOE_REQUEST_H
#define SHOE_REQUEST_H

#include <stdbool.h>
#include <stdint.h>

/* Whether this byte completes an info request. */
bool request_heard(uint8_t byte);

#endif
