/* The viewer's eye: orbits a target, or flies free. Angles in radians, lengths in metres, +Y up. */
#ifndef CAMERA_H
#define CAMERA_H

#include <stdbool.h>

typedef struct camera {
  float eye[3];
  float yaw;           /* 0 looks along -Z, growing to the right */
  float pitch;         /* up positive, within +-89 degrees */
  float distance;      /* from the eye to the point that is orbited, > 0 */
  float field_of_view; /* vertical */
  bool free;           /* flies: turning moves the view round the eye, not the eye round the target */
} camera;

/* From eye to target; a target on the eye looks along -Z. field_of_view: 0 = 45 degrees. */
void camera_look(camera* c, const float eye[3], const float target[3], float field_of_view);

void camera_axes(const camera* c, float forward[3], float right[3], float up[3]); /* unit */
void camera_target(const camera* c, float target[3]);

/* Turns by angles; about the target when orbiting, about the eye when free. */
void camera_turn(camera* c, float yaw, float pitch);
/* Moves eye and target by shares of the picture's height, as a hand drags the scene. */
void camera_pan(camera* c, float x, float y);
/* Nearer (factor < 1) to the target or farther; when free, moves ahead instead. */
void camera_zoom(camera* c, float factor);
/* Flies: metres to the right, up and ahead. */
void camera_fly(camera* c, float right, float up, float ahead);
/* Stands back so that a ball fits the picture; keeps the direction. aspect: width / height. */
void camera_frame(camera* c, const float centre[3], float radius, float aspect);

/* The direction of a pixel, not unit: (x, y) in -1..1 from the left and the bottom, aspect = width / height. */
void camera_ray(const camera* c, float x, float y, float aspect, float direction[3]);

/* The other way round: where a point is seen, false when it is behind the eye. */
bool camera_project(const camera* c, const float point[3], float aspect, float* x, float* y);

/* "ex,ey,ez,tx,ty,tz[,fov]" with fov in degrees, 1..170; 45 when it is left out. Returns false when it is anything else. In
 * doubles, for a scene may lie far from the world's origin. */
bool camera_parse(const char* text, double eye[3], double target[3], double* field_of_view);

#endif
