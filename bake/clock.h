/* Wall-clock seconds, for reports only: nothing that is baked depends on it. What differs between systems is in clock.c. */
#ifndef SCREE_CLOCK_H
#define SCREE_CLOCK_H

double clock_seconds(void);

#endif
