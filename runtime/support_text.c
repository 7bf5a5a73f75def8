#include "support_text.h"

#include <math.h>
#include <string.h>

void text_clear(scree_error* error) {
  if (error != NULL) memset(error, 0, sizeof *error);
}

void text_add(scree_error* error, const char* text) {
  if (error == NULL) return;
  size_t used = strlen(error->message), room = sizeof error->message - 1 - used, size = strlen(text);
  memcpy(error->message + used, text, size < room ? size : room);
}

void text_add_count(scree_error* error, uint64_t number) {
  char digits[24];
  size_t at = sizeof digits - 1;
  digits[at] = '\0';
  do {
    digits[--at] = (char)('0' + number % 10);
    number /= 10;
  } while (number > 0);
  text_add(error, digits + at);
}

void text_add_number(scree_error* error, double number) {
  if (isnan(number)) {
    text_add(error, "not a number");
    return;
  }
  if (signbit(number)) text_add(error, "-");
  number = fabs(number);
  if (isinf(number)) {
    text_add(error, "infinity");
    return;
  }
  int exponent = 0;
  if (number >= 1e9 || (number > 0 && number < 1e-4)) {
    while (number >= 10) number /= 10, ++exponent;
    while (number < 1) number *= 10, --exponent;
  }
  double unit = 1e-5; /* of the last digit that is shown */
  int decimals = 5;
  while (decimals > 0 && number >= 10 * unit * 1e5) unit *= 10, --decimals;
  uint64_t scaled = (uint64_t)(number / unit + 0.5);
  uint64_t one = 1;
  for (int i = 0; i < decimals; ++i) one *= 10;
  if (decimals == 0) scaled = (uint64_t)(number + 0.5);
  text_add_count(error, scaled / one);
  uint64_t fraction = scaled % one;
  if (fraction > 0) {
    char digits[8] = ".";
    size_t length = 1;
    while (fraction > 0 && one > 1) {
      one /= 10;
      digits[length++] = (char)('0' + fraction / one);
      fraction %= one;
    }
    digits[length] = '\0';
    text_add(error, digits);
  }
  if (exponent != 0) {
    text_add(error, exponent < 0 ? "e-" : "e");
    text_add_count(error, (uint64_t)(exponent < 0 ? -exponent : exponent));
  }
}
