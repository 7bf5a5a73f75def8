/* One line of text for scree_error, put together without stdio. */
#ifndef SCREE_SUPPORT_TEXT_H
#define SCREE_SUPPORT_TEXT_H

#include <scree/base.h>

/* All append to error->message and cut off what does not fit; a NULL error is allowed. */
void scree_rt_text_clear(scree_error* error);
void scree_rt_text_add(scree_error* error, const char* text);
void scree_rt_text_add_count(scree_error* error, uint64_t number);
void scree_rt_text_add_number(scree_error* error, double number); /* six significant digits */

#endif
