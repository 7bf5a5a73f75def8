/* On which side points lie, by exact signs: of no use for distances. As long as no product of three differences is below 1e-290. */
#ifndef SCREE_ORIENTATION_H
#define SCREE_ORIENTATION_H

/* 1 where a, b, c run counter-clockwise seen from d, -1 where they run clockwise, 0 where the four lie in a plane. */
int orientation(const double a[3], const double b[3], const double c[3], const double d[3]);

/* The same without looking whether rounding can decide. */
int orientation_exact(const double a[3], const double b[3], const double c[3], const double d[3]);

/* In the plane of coordinates x and y: 1 where a, b, c run counter-clockwise, -1 clockwise, 0 where they lie on a line. */
int orientation_flat(const double a[3], const double b[3], const double c[3], int x, int y);

#endif
