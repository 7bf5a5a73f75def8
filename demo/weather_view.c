#include "weather_view.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "headless.h"
#include "timer.h"
#include "view_window.h"
#include "weather_panel.h"
#include "weather_stage.h"

#define SAMPLES_STILL 32   /* of a picture that does not move */
#define PANEL_WIDTH 392.0f /* window units, with its margins */
#define BUDGET 0.05        /* seconds of steps a frame, at most */

typedef struct viewer {
  const view_options* options;
  weather_session* session;
  GLFWwindow* window;
  render* renderer;
  weather_stage stage;
  weather_panel* panel;
  weather_panel_view view;
  weather_panel_wishes wishes;
  camera camera;
  render_picture picture;
  FILE* log;
  char message[640];
  double pointer[2];
  double due;      /* steps that time owes */
  double moved_at; /* time of the last change of the picture */
  uint32_t coarseness;
  weather_colour shown; /* the surface is painted by it */
  bool stale;           /* the surface is not that of the session */
  bool orbiting, panning, still, edited;
} viewer;

static int status_of(scree_result result) {
  return result == SCREE_ERROR_OUT_OF_MEMORY || result == SCREE_ERROR_UNSUPPORTED ? 1 : 2;
}

static int fail(scree_result result, const char* message) {
  fprintf(stderr, "scree-view: %s\n", message[0] != 0 ? message : scree_result_string(result));
  return status_of(result);
}

/* --- Words --- */

static void say(viewer* v, bool is_error, const char* text) {
  snprintf(v->message, sizeof v->message, "%s", text);
  v->view.message_is_error = is_error;
  if (is_error) fprintf(stderr, "scree-view: %s\n", text);
}

/* A line for the log and for people. */
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
static void
tell(viewer* v, const char* format, ...) {
  char text[sizeof v->message];
  va_list list;
  va_start(list, format);
  vsnprintf(text, sizeof text, format, list);
  va_end(list);
  say(v, false, text);
  if (v->log != NULL) fprintf(v->log, "%s\n", text), fflush(v->log);
}

static void log_state(viewer* v, const char* what) {
  if (v->log == NULL) return;
  scree_weather_stats stats;
  weather_session_stats(v->session, &stats);
  fprintf(v->log, "%s step=%llu variant=%u rock=%llu colluvium=%llu active=%llu step_seconds=%.4f digest=%016llx\n", what,
          (unsigned long long)stats.step, weather_session_variant(v->session), (unsigned long long)stats.rock,
          (unsigned long long)stats.colluvium, (unsigned long long)stats.active, v->view.step_seconds,
          (unsigned long long)weather_session_digest(v->session));
  fflush(v->log);
}

/* --- Commands --- */

static bool check(viewer* v, scree_result result, const scree_error* error) {
  if (result != SCREE_OK) {
    say(v, true, error->message[0] != 0 ? error->message : scree_result_string(result));
    v->view.playing = false;
  }
  return result == SCREE_OK;
}

static void step(viewer* v) {
  scree_error error = {""};
  const double start = timer_seconds();
  scree_weather_stats stats;
  weather_session_stats(v->session, &stats);
  if (stats.rock == 0) {
    v->view.playing = false;
    say(v, false, "no rock is left");
    return;
  }
  check(v, weather_session_step(v->session, &error), &error);
  v->view.step_seconds = timer_seconds() - start;
  v->stale = true;
  log_state(v, "step");
}

static void go(viewer* v, uint32_t to) {
  scree_error error = {""};
  check(v, weather_session_go(v->session, to, &error), &error);
  v->stale = true;
  v->due = 0;
  log_state(v, "go");
}

/* Where --camera says, or else where all of the grid is seen; right: share of the width that the panel covers. */
static void place_camera(const view_options* options, const weather_stage* stage, float aspect, float right, camera* out) {
  if (!options->has_camera) {
    weather_stage_home(stage, aspect, right, out);
    return;
  }
  float eye[3], target[3];
  for (int a = 0; a < 3; ++a) {
    eye[a] = (float)options->eye[a];
    target[a] = (float)options->target[a];
  }
  camera_look(out, eye, target, (float)(options->field_of_view * 3.14159265358979 / 180));
}

static void go_home(viewer* v) {
  int width, height;
  glfwGetWindowSize(v->window, &width, &height);
  if (width < 1 || height < 1) return;
  const float right = v->view.panel && (float)width > 2 * PANEL_WIDTH ? PANEL_WIDTH / (float)width : 0;
  place_camera(v->options, &v->stage, (float)width / (float)height, right, &v->camera);
}

static void save_recipe(viewer* v) {
  scree_error error = {""};
  if (check(v, weather_session_save(v->session, NULL, &error), &error)) tell(v, "saved %s", v->options->weather);
}

/* The recipe's name, beside where pictures go: where the program was started. */
static void export_surface(viewer* v) {
  scree_error error = {""};
  char file[160];
  scree_weather_stats stats;
  weather_session_stats(v->session, &stats);
  const char* name = weather_session_recipe(v->session)->name;
  char plain[64];
  size_t length = 0;
  for (; name[length] != 0 && length + 1 < sizeof plain; ++length) {
    const char c = name[length];
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    plain[length] = good ? c : '_';
  }
  plain[length] = 0;
  snprintf(file, sizeof file, "%s-%u-%llu.glb", length > 0 ? plain : "hoodoo", weather_session_variant(v->session),
           (unsigned long long)stats.step);
  if (check(v, weather_session_export(v->session, file, &error), &error)) tell(v, "exported %s", file);
}

static void keep_age(viewer* v) {
  scree_error error = {""};
  scree_weather_stats stats;
  weather_session_stats(v->session, &stats);
  if (check(v, weather_session_keep_age(v->session, &error), &error))
    tell(v, "age kept: step %llu, %.1f %% left", (unsigned long long)stats.step,
         100 * (double)stats.rock / (double)stats.start_rock);
}

static void save_picture(viewer* v) {
  scree_error error = {""};
  const char* file;
  const scree_result result = view_picture_save(v->options, v->renderer, &v->picture, &file, &error);
  if (check(v, result, &error)) tell(v, "picture %s", file);
}

static void set_variant(viewer* v, uint32_t variant) {
  scree_error error = {""};
  if (variant >= weather_session_recipe(v->session)->variants) return;
  check(v, weather_session_set_variant(v->session, variant, &error), &error);
  v->stale = true;
  log_state(v, "variant");
}

/* --- Events --- */

static void on_key(GLFWwindow* window, int key, int scancode, int action, int mods) {
  (void)scancode;
  viewer* v = glfwGetWindowUserPointer(window);
  v->still = false;
  if (action == GLFW_RELEASE || weather_panel_wants_keys(v->panel)) return;
  const bool control = (mods & GLFW_MOD_CONTROL) != 0;
  scree_weather_stats stats;
  weather_session_stats(v->session, &stats);
  if (key == GLFW_KEY_RIGHT) step(v);
  if (key == GLFW_KEY_LEFT && stats.step > 0) go(v, (uint32_t)stats.step - 1);
  if (action != GLFW_PRESS) return;
  switch (key) {
    case GLFW_KEY_SPACE: v->view.playing = !v->view.playing; break;
    case GLFW_KEY_BACKSPACE: go(v, 0); break;
    case GLFW_KEY_1: v->view.colour = WEATHER_NATURAL; break;
    case GLFW_KEY_2: v->view.colour = WEATHER_DURABILITY; break;
    case GLFW_KEY_3: v->view.colour = WEATHER_CURVATURE; break;
    case GLFW_KEY_PAGE_UP: set_variant(v, weather_session_variant(v->session) + 1); break;
    case GLFW_KEY_PAGE_DOWN: set_variant(v, weather_session_variant(v->session) - 1); break;
    case GLFW_KEY_K: keep_age(v); break;
    case GLFW_KEY_DELETE: v->view.remove_point = v->view.panel; break;
    case GLFW_KEY_E: export_surface(v); break;
    case GLFW_KEY_G: v->view.wireframe = !v->view.wireframe; break;
    case GLFW_KEY_HOME: go_home(v); break;
    case GLFW_KEY_TAB: v->view.panel = !v->view.panel; break;
    case GLFW_KEY_F1: v->view.help = !v->view.help; break;
    case GLFW_KEY_F3: v->view.figures = !v->view.figures; break;
    case GLFW_KEY_P: save_picture(v); break;
    case GLFW_KEY_S:
      if (control) save_recipe(v);
      break;
    case GLFW_KEY_ESCAPE: v->view.help = false; break;
    case GLFW_KEY_Q:
      if (control) glfwSetWindowShouldClose(window, GLFW_TRUE);
      break;
    default: break;
  }
}

static void on_button(GLFWwindow* window, int button, int action, int mods) {
  (void)mods;
  viewer* v = glfwGetWindowUserPointer(window);
  v->still = false;
  glfwGetCursorPos(window, &v->pointer[0], &v->pointer[1]);
  if (action == GLFW_RELEASE) {
    v->orbiting = v->panning = false;
    return;
  }
  if (weather_panel_wants_pointer(v->panel)) return;
  if (button == GLFW_MOUSE_BUTTON_MIDDLE)
    v->panning = true;
  else
    v->orbiting = true;
}

static void on_pointer(GLFWwindow* window, double x, double y) {
  viewer* v = glfwGetWindowUserPointer(window);
  int width, height;
  glfwGetWindowSize(window, &width, &height);
  const float dx = (float)((x - v->pointer[0]) / (height > 0 ? height : 1));
  const float dy = (float)((y - v->pointer[1]) / (height > 0 ? height : 1));
  v->pointer[0] = x;
  v->pointer[1] = y;
  if (v->orbiting) camera_turn(&v->camera, 4.0f * dx, -4.0f * dy);
  if (v->panning) camera_pan(&v->camera, dx, -dy);
}

static void on_wheel(GLFWwindow* window, double x, double y) {
  (void)x;
  viewer* v = glfwGetWindowUserPointer(window);
  if (!weather_panel_wants_pointer(v->panel)) camera_zoom(&v->camera, powf(0.88f, (float)y));
}

/* --- Pictures --- */

/* Everything that the picture depends on; returns whether the camera or what is drawn moved. */
static bool compose(viewer* v) {
  render_picture* p = &v->picture;
  const render_picture before = *p;
  view_look(&v->camera, p);
  p->wireframe = v->view.wireframe;
  return memcmp(before.eye, p->eye, sizeof p->eye) != 0 || memcmp(before.forward, p->forward, sizeof p->forward) != 0 ||
         before.field_of_view != p->field_of_view || before.wireframe != p->wireframe;
}

static void draw(viewer* v, uint32_t width, uint32_t height, bool changed) {
  render_picture* p = &v->picture;
  const double now = timer_seconds();
  if (compose(v) || changed) v->moved_at = now;
  const bool moving = v->view.playing || now - v->moved_at < 0.15;
  const uint32_t coarse = moving ? v->coarseness : 1;
  p->width = width / coarse > 0 ? width / coarse : 1;
  p->height = height / coarse > 0 ? height / coarse : 1;
  p->samples = 1;
  p->draft = moving && v->coarseness > 1;
  const uint32_t enough = v->options->samples > 0 ? v->options->samples : SAMPLES_STILL;
  p->samples_most = moving ? 1 : enough;
  if (render_draw(v->renderer, p) != SCREE_OK) say(v, true, "the picture cannot be drawn: out of memory");
  glFinish();
  const double seconds = timer_seconds() - now;
  render_stats stats;
  render_get_stats(v->renderer, &stats);
  v->view.frame_seconds = seconds;
  v->view.triangles = stats.free_triangles;
  v->view.sent = stats.free_sent;
  const bool was_still = v->still;
  v->still = !moving && stats.samples >= enough;
  if (v->still && !was_still && v->log != NULL) fprintf(v->log, "still samples=%u\n", stats.samples), fflush(v->log);
  if (moving) v->coarseness = view_coarseness(v->coarseness, seconds);
}

static void fill_view(viewer* v) {
  weather_panel_view* w = &v->view;
  weather_session* s = v->session;
  w->recipe = weather_session_recipe(s);
  weather_session_stats(s, &w->stats);
  w->variant = weather_session_variant(s);
  w->begun = weather_session_phases_begun(s);
  w->last = weather_session_last(s);
  w->snapshots = weather_session_snapshots(s);
  w->age_count = weather_session_ages(s);
  for (uint32_t i = 0; i < w->age_count; ++i)
    if (!weather_session_age_step(s, i, &w->age_steps[i])) w->age_steps[i] = UINT32_MAX;
  w->unsaved = weather_session_unsaved(s);
  w->rules = *weather_session_rules(s);
  w->message = v->message;
}

static void obey(viewer* v, bool was_held) {
  const weather_panel_wishes* w = &v->wishes;
  scree_error error = {""};
  if (w->held && !was_held) log_state(v, "held");
  if (w->rules) {
    const scree_result result = weather_session_set_rules(v->session, &v->view.rules, &error);
    check(v, result, &error);
    v->stale = true;
    v->edited = result == SCREE_OK;
    if (w->held) log_state(v, "edit");
  }
  if (v->edited && !w->held) {
    v->edited = false;
    log_state(v, "rules");
  }
  if (w->step) step(v);
  if (w->restart) go(v, 0);
  if (w->go) go(v, w->go_to);
  if (w->variant != v->view.variant) set_variant(v, w->variant);
  if (w->keep_age) keep_age(v);
  if (w->drop_age != UINT32_MAX) check(v, weather_session_drop_age(v->session, w->drop_age, &error), &error);
  if (w->drop_phase != UINT32_MAX) {
    check(v, weather_session_drop_phase(v->session, w->drop_phase, &error), &error);
    v->stale = true;
  }
  if (w->flatten) {
    check(v, weather_session_flatten(v->session, &error), &error);
    v->stale = true;
  }
  if (w->save) save_recipe(v);
  if (w->export_glb) export_surface(v);
  if (w->picture) save_picture(v);
  if (w->home) go_home(v);
}

/* As many steps as time owes; none while something is held: what is being changed takes effect at the next step. */
static void play(viewer* v, double seconds) {
  if (!v->view.playing || v->wishes.held) {
    v->due = 0;
    return;
  }
  v->due += fmin(seconds, 0.25) * (double)v->view.steps_per_second;
  const double start = timer_seconds();
  while (v->due >= 1 && v->view.playing) {
    step(v);
    v->due -= 1;
    if (timer_seconds() - start > BUDGET) v->due = 0; /* it cannot be had faster */
  }
}

static void frame(viewer* v, double seconds) {
  int width, height;
  glfwGetFramebufferSize(v->window, &width, &height);
  if (width < 1 || height < 1) return;
  play(v, seconds);
  const bool changed = v->stale || v->shown != v->view.colour;
  if (changed) {
    scree_error error = {""};
    v->stale = false;
    v->shown = v->view.colour;
    if (check(v, weather_stage_show(&v->stage, v->shown, &error), &error) && v->log != NULL)
      fprintf(v->log, "surface seconds=%.4f upload_seconds=%.4f\n", v->stage.mesh_seconds, v->stage.upload_seconds), fflush(v->log);
    v->view.mesh_seconds = v->stage.mesh_seconds + v->stage.upload_seconds;
  }
  draw(v, (uint32_t)width, (uint32_t)height, changed);
  render_show(v->renderer, 0, (uint32_t)width, (uint32_t)height);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width, height);
  fill_view(v);
  const bool playing = v->view.playing, was_held = v->wishes.held;
  weather_panel_draw(v->panel, &v->view, &v->wishes);
  obey(v, was_held);
  if (playing != v->view.playing || v->wishes.held) v->moved_at = timer_seconds();
  glfwSwapBuffers(v->window);
}

static void run(viewer* v) {
  double before = timer_seconds();
  bool told = false;
  while (!glfwWindowShouldClose(v->window)) {
    /* A finished picture waits for events; an unfinished one looks for them in passing. */
    if (v->still && !v->stale && v->shown == v->view.colour)
      glfwWaitEventsTimeout(0.5);
    else
      glfwPollEvents();
    const double now = timer_seconds();
    frame(v, now - before);
    before = now;
    float min[2], max[2];
    if (!told && v->log != NULL && weather_panel_graph(v->panel, min, max)) {
      fprintf(v->log, "graph %.0f %.0f %.0f %.0f\n", (double)min[0], (double)min[1], (double)max[0], (double)max[1]);
      fflush(v->log);
      told = true;
    }
  }
}

/* --- Opening --- */

static int show(viewer* v, const scree_jobs* jobs) {
  scree_error error = {""};
  const render_desc desc = {.no_indirect = v->options->no_indirect, .jobs = *jobs};
  const scree_result result = render_create(&desc, &v->renderer, &error);
  if (result != SCREE_OK) return fail(result, error.message);
  weather_stage_create(&v->stage, v->session, v->renderer);
  render_picture_init(&v->picture);
  weather_stage_light(&v->picture);
  v->picture.width = v->options->width;
  v->picture.height = v->options->height;
  v->coarseness = 1;
  v->stale = true;
  v->view = (weather_panel_view){.keys = weather_keys,
                                 .panel = !v->options->no_panel,
                                 .figures = !v->options->no_panel,
                                 .steps_per_second = 10,
                                 .colour = v->options->paint,
                                 .wireframe = v->options->wireframe};
  go_home(v);
  log_state(v, "open");
  glfwSetWindowUserPointer(v->window, v);
  glfwSetKeyCallback(v->window, on_key);
  glfwSetMouseButtonCallback(v->window, on_button);
  glfwSetCursorPosCallback(v->window, on_pointer);
  glfwSetScrollCallback(v->window, on_wheel);
  v->panel = weather_panel_create(v->window);
  if (v->panel == NULL) return 1;
  run(v);
  return 0;
}

static int run_window(const view_options* options, weather_session* session, const scree_jobs* jobs) {
  viewer* v = calloc(1, sizeof *v);
  if (v == NULL) return 1;
  int status = 1;
  v->options = options;
  v->session = session;
  v->window = view_window_open(options, options->weather);
  if (v->window != NULL) {
    v->log = view_log_open(options);
    status = show(v, jobs);
    weather_panel_destroy(v->panel);
    weather_stage_destroy(&v->stage);
    render_destroy(v->renderer);
    view_log_close(v->log);
    glfwDestroyWindow(v->window);
  }
  free(v);
  glfwTerminate();
  return status;
}

/* --- One picture --- */

static scree_result draw_picture(const view_options* options, weather_session* session, render* r, scree_error* error) {
  weather_stage stage;
  weather_stage_create(&stage, session, r);
  scree_result result = weather_stage_show(&stage, options->paint, error);
  camera eye;
  place_camera(options, &stage, (float)options->width / (float)options->height, 0, &eye);
  weather_stage_destroy(&stage);
  if (result != SCREE_OK) return result;
  render_picture picture;
  render_picture_init(&picture);
  weather_stage_light(&picture);
  view_look(&eye, &picture);
  picture.width = options->width;
  picture.height = options->height;
  picture.samples = options->samples > 0 ? options->samples : 8;
  picture.wireframe = options->wireframe;
  result = render_draw(r, &picture);
  const char* file;
  return result == SCREE_OK ? view_picture_save(options, r, &picture, &file, error) : result;
}

static int run_headless(const view_options* options, weather_session* session, const scree_jobs* jobs) {
  scree_error error = {""};
  headless* context;
  scree_result result = headless_create(&context, &error);
  if (result != SCREE_OK) return fail(result, error.message);
  const render_desc desc = {.no_indirect = options->no_indirect, .jobs = *jobs};
  render* r;
  result = render_create(&desc, &r, &error);
  if (result == SCREE_OK) {
    result = draw_picture(options, session, r, &error);
    render_destroy(r);
  }
  headless_destroy(context);
  if (result != SCREE_OK) return result == SCREE_ERROR_IO ? (fail(result, error.message), 1) : fail(result, error.message);
  FILE* log = view_log_open(options);
  scree_weather_stats stats;
  weather_session_stats(session, &stats);
  if (log != NULL)
    fprintf(log, "picture step=%llu rock=%llu colluvium=%llu active=%llu digest=%016llx\n", (unsigned long long)stats.step,
            (unsigned long long)stats.rock, (unsigned long long)stats.colluvium, (unsigned long long)stats.active,
            (unsigned long long)weather_session_digest(session));
  view_log_close(log);
  return 0;
}

int weather_view_run(const view_options* options, const scree_jobs* jobs) {
  scree_error error = {""};
  const weather_session_desc desc = {.path = options->weather, .variant = options->variant, .jobs = *jobs};
  weather_session* session;
  scree_result result = weather_session_open(&desc, &session, &error);
  if (result != SCREE_OK) return fail(result, error.message);
  int status;
  result = weather_session_go(session, options->steps, &error);
  if (result != SCREE_OK)
    status = fail(result, error.message);
  else
    status = options->headless ? run_headless(options, session, jobs) : run_window(options, session, jobs);
  weather_session_close(session);
  return status;
}
