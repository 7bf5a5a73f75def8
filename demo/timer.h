/* A clock of the programs. What differs between systems is in timer.c. */
#ifndef TIMER_H
#define TIMER_H

/* Seconds since some moment in the past; only goes forward. */
double timer_seconds(void);

#endif
