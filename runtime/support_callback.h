/* Callbacks of users, held to what they promised. */
#ifndef SCREE_SUPPORT_CALLBACK_H
#define SCREE_SUPPORT_CALLBACK_H

#include "support_program.h"

/* Debug builds only: tells the log, or stops the program without one, when a distance is not a number or two of them differ by more
 * than the stated bound allows. Points are in the callback's own space. */
void scree_rt_support_callback_check(const support_op* op, const float* x, const float* y, const float* z, const float* distance,
                                     uint32_t count);

#endif
