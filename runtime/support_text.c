#include "support_text.h"

#include <math.h>
#include <string.h>

void scree_rt_text_clear(scree_error* error) {
  if (error != NULL) memset(error, 0, sizeof *error);
}

void scree_rt_text_add(scree_error* error, const char* text) {
  if (error == NULL) return;
  size_t used = strlen(error->message), room = sizeof error->message - 1 - used, size = strlen(text);
  memcpy(error->message + used, text, size < room ? size : room);
}

void scree_rt_text_add_count(scree_error* error, uint64_t number) {
  char digits[24];
  size_t at = sizeof digits - 1;
  digits[at] = '\0';
  do {
    digits[--at] = (char)('0' + number % 10);
    number /= 10;
  } while (number > 0);
  scree_rt_text_add(error, digits + at);
}

void scree_rt_text_add_number(scree_error* error, double number) {
  if (isnan(number)) {
    scree_rt_text_add(error, "not a number");
    return;
  }
  if (signbit(number)) scree_rt_text_add(error, "-");
  number = fabs(number);
  if (isinf(number)) {
    scree_rt_text_add(error, "infinity");
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
  uint64_t scaled = (uint64_t)(number / (decimals > 0 ? unit : 1) + 0.5);
  char fraction[8] = ".";
  int length = 1; /* with the point, without zeros at the end */
  for (int i = decimals; i > 0; --i) {
    fraction[i] = (char)('0' + scaled % 10);
    if (length == 1 && fraction[i] != '0') length = i + 1;
    scaled /= 10;
  }
  fraction[length] = '\0';
  scree_rt_text_add_count(error, scaled);
  if (length > 1) scree_rt_text_add(error, fraction);
  if (exponent != 0) {
    scree_rt_text_add(error, exponent < 0 ? "e-" : "e");
    scree_rt_text_add_count(error, (uint64_t)(exponent < 0 ? -exponent : exponent));
  }
}
