#include "support_callback.h"

#ifndef NDEBUG

#include <assert.h>
#include <math.h>

#include "support_text.h"

/* Each point is held against this many before it. */
enum { COMPANIONS = 8 };

static void add_point(scree_error* text, float x, float y, float z) {
  const float p[3] = {x, y, z};
  for (int a = 0; a < 3; ++a) {
    scree_rt_text_add(text, a == 0 ? " (" : ", ");
    scree_rt_text_add_number(text, (double)p[a]);
  }
  scree_rt_text_add(text, ")");
}

static void begin(const support_op* op, scree_error* text) {
  scree_rt_text_clear(text);
  scree_rt_text_add(text, "shape ");
  scree_rt_text_add_count(text, op->callback.shape);
  scree_rt_text_add(text, ": the callback's distance at");
}

static void tell(const support_op* op, const scree_error* text) {
  const scree_log* log = op->callback.log;
  if (log->write != NULL) log->write(log->user, SCREE_LOG_ERROR, text->message);
  assert(log->write != NULL && "a callback breaks its promises, and the support has no log to tell it");
}

void scree_rt_support_callback_check(const support_op* op, const float* x, const float* y, const float* z, const float* distance,
                                     uint32_t count) {
  scree_error text;
  double bound = (double)op->callback.lipschitz;
  for (uint32_t i = 0; i < count; ++i) {
    double d = (double)distance[i], px = (double)x[i], py = (double)y[i], pz = (double)z[i];
    if (isnan(d)) {
      begin(op, &text);
      add_point(&text, x[i], y[i], z[i]);
      scree_rt_text_add(&text, " is not a number");
      tell(op, &text);
      return; /* one message a call */
    }
    for (uint32_t k = i > COMPANIONS ? i - COMPANIONS : 0; k < i; ++k) {
      double e = (double)distance[k], qx = (double)x[k], qy = (double)y[k], qz = (double)z[k];
      double apart = sqrt((px - qx) * (px - qx) + (py - qy) * (py - qy) + (pz - qz) * (pz - qz));
      double places = fabs(px) + fabs(py) + fabs(pz) + fabs(qx) + fabs(qy) + fabs(qz);
      double rounding = 1e-5 * (bound * places + fabs(d) + fabs(e));
      if (!isfinite(d) || !isfinite(e) || fabs(d - e) <= bound * apart * 1.0001 + rounding) continue;
      begin(op, &text);
      add_point(&text, x[i], y[i], z[i]);
      scree_rt_text_add(&text, " and");
      add_point(&text, x[k], y[k], z[k]);
      scree_rt_text_add(&text, " differs by ");
      scree_rt_text_add_number(&text, fabs(d - e));
      scree_rt_text_add(&text, " over ");
      scree_rt_text_add_number(&text, apart);
      scree_rt_text_add(&text, " metres, its bound is ");
      scree_rt_text_add_number(&text, bound);
      tell(op, &text);
      return;
    }
  }
}

#else

typedef int nothing_to_check; /* a file of C has something in it */

#endif
