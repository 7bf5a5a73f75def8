#include "window.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "edit.h"
#include "outline.h"
#include "panel.h"
#include "stage.h"
#include "timer.h"
#include "view_window.h"

#define SAMPLES_STILL 48  /* of a picture that does not move */
#define DECODE_MOVING 192 /* meshes a frame while something moves */
#define ARROW_PIXELS 9.0  /* how near the pointer must be to an arrow */

typedef struct viewer {
  const view_options* options;
  scene_model* scene;
  GLFWwindow* window;
  render* renderer;
  stage* stage;
  editor edit;
  panel* panel;
  panel_view view;
  camera camera;
  outline outline;
  render_picture picture;
  FILE* log;
  char message[640];
  uint32_t stone_counts[SCENE_FIELDS_MAX];
  double pointer[2];             /* window units, of the last event */
  double moved_at;               /* time of the last change of the picture */
  double sample_seconds;         /* of the last sample at full size */
  uint32_t coarseness;           /* 1 = every pixel, while moving */
  int hot_arrow;                 /* the arrow under the pointer, -1 none */
  bool orbiting, panning, still; /* still: the picture may gather samples */
} viewer;

/* --- Words --- */

static void say(viewer* v, bool is_error, const char* text) {
  snprintf(v->message, sizeof v->message, "%s", text);
  v->view.message_is_error = is_error;
  if (is_error) fprintf(stderr, "scree-view: %s\n", text);
}

static void log_field(viewer* v, const char* what, uint32_t field) {
  if (v->log == NULL) return;
  fprintf(v->log, "%s field=%u instances=%u seconds=%.4f\n", what, field, stage_stone_count(v->stage, field),
          stage_update_seconds(v->stage, field));
  fflush(v->log);
}

/* --- Places --- */

static float aspect(const viewer* v) {
  return (float)v->picture.width / (float)v->picture.height;
}

/* Pointer in -1..1 from the left and the bottom. */
static void pointer_on_screen(const viewer* v, float* x, float* y) {
  int width, height;
  glfwGetWindowSize(v->window, &width, &height);
  *x = (float)(2 * v->pointer[0] / (width > 0 ? width : 1) - 1);
  *y = (float)(1 - 2 * v->pointer[1] / (height > 0 ? height : 1));
}

static void pointer_ray(const viewer* v, double eye[3], double direction[3]) {
  float x, y, d[3];
  double origin[3];
  pointer_on_screen(v, &x, &y);
  camera_ray(&v->camera, x, y, aspect(v), d);
  stage_origin(v->stage, origin);
  for (int a = 0; a < 3; ++a) {
    eye[a] = (double)v->camera.eye[a] + origin[a];
    direction[a] = (double)d[a];
  }
}

/* The world point of the selected node and how long its arrows are. */
static bool arrow_place(const viewer* v, double place[3], double* length) {
  edit_frame frame;
  if (v->edit.node == NULL || !edit_node_frame(v->scene->fields[v->edit.field].support, v->edit.node, &frame, NULL)) return false;
  memcpy(place, frame.translation, sizeof frame.translation);
  double origin[3], away = 0;
  stage_origin(v->stage, origin);
  for (int a = 0; a < 3; ++a) {
    double d = place[a] - origin[a] - (double)v->camera.eye[a];
    away += d * d;
  }
  *length = 0.22 * sqrt(away) * (double)tanf(0.5f * v->camera.field_of_view);
  return true;
}

/* Which arrow the pointer is on, or -1. */
static int arrow_at_pointer(const viewer* v) {
  double place[3], length, origin[3];
  if (!arrow_place(v, place, &length)) return -1;
  stage_origin(v->stage, origin);
  float px, py, from[3], start[2];
  int width, height, best = -1;
  glfwGetWindowSize(v->window, &width, &height);
  pointer_on_screen(v, &px, &py);
  for (int a = 0; a < 3; ++a) from[a] = (float)(place[a] - origin[a]);
  if (!camera_project(&v->camera, from, aspect(v), &start[0], &start[1])) return -1;
  double nearest = ARROW_PIXELS;
  for (int axis = 0; axis < 3; ++axis) {
    float to[3] = {from[0], from[1], from[2]}, end[2];
    to[axis] += (float)length;
    if (!camera_project(&v->camera, to, aspect(v), &end[0], &end[1])) continue;
    /* Distance of the pointer from the segment, in pixels. */
    double ux = 0.5 * width * (double)(end[0] - start[0]), uy = 0.5 * height * (double)(end[1] - start[1]);
    double wx = 0.5 * width * (double)(px - start[0]), wy = 0.5 * height * (double)(py - start[1]);
    double squared = ux * ux + uy * uy, t = squared > 1 ? (wx * ux + wy * uy) / squared : 0;
    t = fmin(fmax(t, 0.15), 1); /* its foot belongs to all three */
    double distance = hypot(wx - t * ux, wy - t * uy);
    if (distance < nearest) {
      nearest = distance;
      best = axis;
    }
  }
  return best;
}

/* What the pointer is on: a world point, and the stone's field or RENDER_NOTHING. */
static bool pick(const viewer* v, double point[3], uint32_t* field) {
  float x, y, local[3];
  uint32_t stone;
  double origin[3];
  *field = RENDER_NOTHING;
  pointer_on_screen(v, &x, &y);
  const float column = (x + 1) * 0.5f * (float)v->picture.width, row = (1 - y) * 0.5f * (float)v->picture.height;
  if (column < 0 || row < 0 || !render_pick(v->renderer, (uint32_t)column, (uint32_t)row, &stone, local)) return false;
  stage_origin(v->stage, origin);
  for (int a = 0; a < 3; ++a) point[a] = (double)local[a] + origin[a];
  /* Stones come field after field, as stage_show lays them out. */
  for (uint32_t f = 0; stone != RENDER_NOTHING && f < v->scene->field_count; ++f) {
    uint32_t count = stage_stone_count(v->stage, f);
    if (stone < count) {
      *field = f;
      break;
    }
    stone -= count;
  }
  return true;
}

/* --- Keeping up with edits --- */

static void count_stones(viewer* v) {
  for (uint32_t f = 0; f < v->scene->field_count; ++f) v->stone_counts[f] = stage_stone_count(v->stage, f);
}

static bool fields_changed(const viewer* v) {
  for (uint32_t f = 0; f < v->scene->field_count; ++f)
    if (v->edit.changed[f] != 0) return true;
  return false;
}

static bool edits_wait(const viewer* v) {
  return fields_changed(v) || v->edit.changed_fields || v->edit.changed_ground;
}

/* Queries what has changed. */
static void keep_up(viewer* v) {
  scree_error error = {""};
  bool shown = false;
  if (v->edit.changed_fields) {
    if (stage_update_all(v->stage, &error) != SCREE_OK) say(v, true, error.message);
    memset(v->edit.changed, 0, sizeof v->edit.changed);
    v->edit.changed_fields = false;
    for (uint32_t f = 0; f < v->scene->field_count; ++f) log_field(v, "open", f);
    shown = true;
  }
  if (v->edit.changed_ground) {
    if (stage_update_ground(v->stage, &error) != SCREE_OK) say(v, true, error.message);
    v->edit.changed_ground = false;
  }
  if (fields_changed(v)) {
    const double start = timer_seconds();
    if (stage_update_fields(v->stage, v->edit.changed, &error) == SCREE_OK)
      v->message[0] = 0;
    else
      say(v, true, error.message);
    v->view.query_seconds = timer_seconds() - start;
    for (uint32_t f = 0; f < v->scene->field_count; ++f)
      if (v->edit.changed[f] != 0) log_field(v, "query", f);
    memset(v->edit.changed, 0, sizeof v->edit.changed);
    shown = true;
  }
  if (!shown) return;
  if (stage_show(v->stage) != SCREE_OK) say(v, true, "not enough memory for all stones");
  count_stones(v);
  v->moved_at = timer_seconds();
}

/* --- Commands --- */

static void go_home(viewer* v) {
  const scene_camera* c = &v->scene->camera;
  if (v->options->has_camera)
    stage_camera(v->stage, v->options->eye, v->options->target, v->options->field_of_view, &v->camera);
  else
    stage_camera(v->stage, c->eye, c->target, c->fov, &v->camera);
}

static void look_at_selected(viewer* v) {
  double place[3], length, origin[3];
  float centre[3], radius;
  if (arrow_place(v, place, &length)) {
    double min[3], max[3], size = 0;
    edit_frame frame;
    stage_origin(v->stage, origin);
    for (int a = 0; a < 3; ++a) centre[a] = (float)(place[a] - origin[a]);
    if (edit_leaf_box(v->edit.node, min, max) &&
        edit_node_frame(v->scene->fields[v->edit.field].support, v->edit.node, &frame, NULL)) {
      for (int a = 0; a < 3; ++a) size += (max[a] - min[a]) * (max[a] - min[a]);
      radius = (float)(0.6 * sqrt(size) * frame.scale);
    } else if (stage_ball(v->stage, centre, &radius)) {
      radius *= 1.05f;
    } else {
      return;
    }
  } else if (!stage_ball(v->stage, centre, &radius)) {
    return;
  }
  camera_frame(&v->camera, centre, radius, aspect(v));
}

static void save_scene(viewer* v) {
  scree_error error = {""};
  char text[sizeof v->message];
  edit_commit(&v->edit);
  if (scene_save(v->scene, v->options->paths.scene, &error) != SCREE_OK) {
    say(v, true, error.message);
    return;
  }
  v->edit.unsaved = false;
  snprintf(text, sizeof text, "saved %s", v->options->paths.scene);
  say(v, false, text);
  if (v->log != NULL) fprintf(v->log, "%s\n", text), fflush(v->log);
}

static void save_picture(viewer* v) {
  scree_error error = {""};
  const char* file;
  const scree_result result = view_picture_save(v->options, v->renderer, &v->picture, &file, &error);
  if (result != SCREE_OK) {
    say(v, true, error.message[0] != 0 ? error.message : scree_result_string(result));
  } else {
    char text[sizeof v->message];
    snprintf(text, sizeof text, "picture %s", file);
    say(v, false, text);
    if (v->log != NULL) fprintf(v->log, "%s\n", text), fflush(v->log);
  }
}

static void undo(viewer* v) {
  if (!edit_undo(&v->edit)) say(v, false, "nothing to undo");
}

static void redo(viewer* v) {
  if (!edit_redo(&v->edit)) say(v, false, "nothing to redo");
}

/* --- Events --- */

static void on_key(GLFWwindow* window, int key, int scancode, int action, int mods) {
  (void)scancode;
  viewer* v = glfwGetWindowUserPointer(window);
  if (action != GLFW_PRESS || panel_wants_keys(v->panel)) return;
  const bool control = (mods & GLFW_MOD_CONTROL) != 0;
  switch (key) {
    case GLFW_KEY_1: v->view.colour = RENDER_COLOUR_STONE; break;
    case GLFW_KEY_2: v->view.colour = RENDER_COLOUR_LOD; break;
    case GLFW_KEY_3: v->view.colour = RENDER_COLOUR_TILE; break;
    case GLFW_KEY_G: v->view.wireframe = !v->view.wireframe; break;
    case GLFW_KEY_F: v->view.flying = !v->view.flying; break;
    case GLFW_KEY_HOME: go_home(v); break;
    case GLFW_KEY_TAB: v->view.panel = !v->view.panel; break;
    case GLFW_KEY_F1: v->view.help = !v->view.help; break;
    case GLFW_KEY_F3: v->view.figures = !v->view.figures; break;
    case GLFW_KEY_P: save_picture(v); break;
    case GLFW_KEY_Z:
      if (control)
        undo(v);
      else
        look_at_selected(v);
      break;
    case GLFW_KEY_Y:
      if (control) redo(v);
      break;
    case GLFW_KEY_S:
      if (control) save_scene(v);
      break;
    case GLFW_KEY_D:
      if (control && edit_duplicate(&v->edit)) edit_commit(&v->edit);
      break;
    case GLFW_KEY_DELETE:
      if (edit_delete(&v->edit))
        edit_commit(&v->edit);
      else if (v->edit.node != NULL)
        say(v, true, "a field keeps its last support");
      break;
    case GLFW_KEY_ESCAPE:
      v->edit.node = NULL;
      v->view.help = false;
      break;
    case GLFW_KEY_Q:
      if (control) glfwSetWindowShouldClose(window, GLFW_TRUE);
      break;
    default: break;
  }
}

static void press_left(viewer* v, int mods) {
  double point[3], eye[3], direction[3], place[3], length;
  uint32_t field;
  float x, y;
  pointer_on_screen(v, &x, &y);
  int arrow = arrow_at_pointer(v);
  if (arrow >= 0 && arrow_place(v, place, &length)) {
    /* Grab the arrow where it is nearest to the pointer: a drag of no length moves nothing. */
    pointer_ray(v, eye, direction);
    static const edit_drag_kind kinds[3] = {EDIT_DRAG_X, EDIT_DRAG_Y, EDIT_DRAG_Z};
    edit_drag_begin(&v->edit, kinds[arrow], place, (double)y);
    edit_drag_grab(&v->edit, eye, direction);
    return;
  }
  if (!pick(v, point, &field) || field == RENDER_NOTHING) {
    v->edit.node = NULL;
    return;
  }
  scene_node* node = edit_leaf_at(v->scene, field, point);
  if (node == NULL) { /* a cliff has no shapes */
    v->edit.field = field;
    v->edit.node = NULL;
    return;
  }
  if (node != v->edit.node || field != v->edit.field) {
    v->edit.field = field;
    v->edit.node = node;
    if (v->log != NULL) fprintf(v->log, "select field=%u support=%s\n", field, scene_kind_name(node->kind)), fflush(v->log);
  }
  edit_drag_kind kind = mods & GLFW_MOD_CONTROL ? EDIT_DRAG_SCALE : mods & GLFW_MOD_SHIFT ? EDIT_DRAG_VERTICAL : EDIT_DRAG_GROUND;
  edit_drag_begin(&v->edit, kind, point, 0.5 * ((double)y + 1));
}

static void on_button(GLFWwindow* window, int button, int action, int mods) {
  viewer* v = glfwGetWindowUserPointer(window);
  glfwGetCursorPos(window, &v->pointer[0], &v->pointer[1]);
  if (action == GLFW_RELEASE) {
    if (button == GLFW_MOUSE_BUTTON_LEFT) edit_drag_end(&v->edit);
    if (button == GLFW_MOUSE_BUTTON_RIGHT) v->orbiting = false;
    if (button == GLFW_MOUSE_BUTTON_MIDDLE) v->panning = false;
    return;
  }
  if (panel_wants_pointer(v->panel)) return;
  if (button == GLFW_MOUSE_BUTTON_LEFT) press_left(v, mods);
  if (button == GLFW_MOUSE_BUTTON_RIGHT) v->orbiting = true;
  if (button == GLFW_MOUSE_BUTTON_MIDDLE) v->panning = true;
}

static void on_pointer(GLFWwindow* window, double x, double y) {
  viewer* v = glfwGetWindowUserPointer(window);
  int width, height;
  glfwGetWindowSize(window, &width, &height);
  const float dx = (float)((x - v->pointer[0]) / (height > 0 ? height : 1));
  const float dy = (float)((y - v->pointer[1]) / (height > 0 ? height : 1));
  v->pointer[0] = x;
  v->pointer[1] = y;
  if (v->orbiting) camera_turn(&v->camera, v->camera.free ? 2.0f * dx : 4.0f * dx, v->camera.free ? -2.0f * dy : -4.0f * dy);
  if (v->panning) camera_pan(&v->camera, dx, -dy);
  if (v->edit.drag != EDIT_DRAG_NONE) {
    double eye[3], direction[3];
    float sx, sy;
    pointer_on_screen(v, &sx, &sy);
    pointer_ray(v, eye, direction);
    edit_drag_to(&v->edit, eye, direction, 0.5 * ((double)sy + 1));
  }
}

static void on_wheel(GLFWwindow* window, double x, double y) {
  (void)x;
  viewer* v = glfwGetWindowUserPointer(window);
  if (!panel_wants_pointer(v->panel)) camera_zoom(&v->camera, powf(0.88f, (float)y));
}

/* Keys that are held. */
static void fly(viewer* v, double seconds) {
  if (!v->camera.free || panel_wants_keys(v->panel)) return;
  if (glfwGetKey(v->window, GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS) return;
  static const int keys[6] = {GLFW_KEY_D, GLFW_KEY_A, GLFW_KEY_E, GLFW_KEY_Q, GLFW_KEY_W, GLFW_KEY_S};
  float way[3] = {0, 0, 0};
  for (int i = 0; i < 6; ++i)
    if (glfwGetKey(v->window, keys[i]) == GLFW_PRESS) way[i / 2] += i & 1 ? -1.0f : 1.0f;
  if (way[0] == 0 && way[1] == 0 && way[2] == 0) return;
  float centre[3], radius = 10;
  stage_ball(v->stage, centre, &radius);
  float speed = 0.35f * radius * (float)fmin(seconds, 0.25);
  if (glfwGetKey(v->window, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS) speed *= 4;
  camera_fly(&v->camera, way[0] * speed, way[1] * speed, way[2] * speed);
}

/* --- Pictures --- */

/* Fills in what the camera and the panel say; true when that is another picture than before. */
static bool compose(viewer* v) {
  render_picture before = v->picture;
  render_picture* p = &v->picture;
  stage_light(v->stage, p);
  view_look(&v->camera, p);
  p->colour = v->view.colour;
  p->wireframe = v->view.wireframe;
  return memcmp(before.eye, p->eye, sizeof p->eye) != 0 || memcmp(before.forward, p->forward, sizeof p->forward) != 0 ||
         before.field_of_view != p->field_of_view || before.colour != p->colour || before.wireframe != p->wireframe ||
         memcmp(before.sun, p->sun, sizeof p->sun) != 0 || memcmp(before.sun_colour, p->sun_colour, sizeof p->sun_colour) != 0 ||
         memcmp(before.sky, p->sky, sizeof p->sky) != 0 ||
         memcmp(before.ground_colour, p->ground_colour, sizeof p->ground_colour) != 0 || before.ground_height != p->ground_height ||
         memcmp(before.water_colour, p->water_colour, sizeof p->water_colour) != 0;
}

static void draw_scene(viewer* v, uint32_t width, uint32_t height) {
  static const uint8_t amber[4] = {255, 190, 70, 255};
  render_picture* p = &v->picture;
  const double now = timer_seconds();
  if (compose(v)) v->moved_at = now;
  const bool first = v->view.stats.samples == 0; /* worth the wait for all of its meshes */
  const bool moving = now - v->moved_at < 0.15 || edits_wait(v) || v->view.stats.meshes_missing > 0;
  const uint32_t coarse = moving ? v->coarseness : 1;
  p->width = width / coarse > 0 ? width / coarse : 1;
  p->height = height / coarse > 0 ? height / coarse : 1;
  p->samples = 1;
  p->draft = moving && v->coarseness > 1;
  const uint32_t enough = v->options->samples > 0 ? v->options->samples : SAMPLES_STILL;
  p->samples_most = moving ? 1 : enough;
  p->decode_budget = first ? 0 : DECODE_MOVING;

  outline_clear(&v->outline);
  stage_origin(v->stage, v->outline.origin);
  double place[3], length;
  if (v->edit.node != NULL)
    outline_add_node(&v->outline, v->scene->fields[v->edit.field].support, v->edit.node, &v->options->paths, stage_files(v->stage),
                     amber);
  if (arrow_place(v, place, &length)) outline_add_arrows(&v->outline, place, length, v->hot_arrow);
  p->segments = v->outline.segments;
  p->segment_count = v->outline.count;

  if (render_draw(v->renderer, p) != SCREE_OK) say(v, true, "the picture cannot be drawn: out of memory");
  glFinish();
  const double seconds = timer_seconds() - now;
  render_get_stats(v->renderer, &v->view.stats);
  v->view.frame_seconds = seconds;
  const bool was_still = v->still;
  v->still = !moving && v->view.stats.samples >= enough && v->view.stats.meshes_missing == 0;
  if (v->still && !was_still && v->log != NULL) fprintf(v->log, "still samples=%u\n", v->view.stats.samples), fflush(v->log);
  if (moving) v->coarseness = view_coarseness(v->coarseness, seconds);
}

static void frame(viewer* v, double seconds_since) {
  int width, height;
  glfwGetFramebufferSize(v->window, &width, &height);
  if (width < 1 || height < 1) return;
  fly(v, seconds_since);
  v->camera.free = v->view.flying;
  if (v->edit.drag == EDIT_DRAG_NONE) {
    int arrow = panel_wants_pointer(v->panel) ? -1 : arrow_at_pointer(v);
    if (arrow != v->hot_arrow) v->hot_arrow = arrow;
  }
  keep_up(v);
  draw_scene(v, (uint32_t)width, (uint32_t)height);
  render_show(v->renderer, 0, (uint32_t)width, (uint32_t)height);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width, height);

  float target[3];
  double origin[3];
  camera_target(&v->camera, target);
  stage_origin(v->stage, origin);
  for (int a = 0; a < 3; ++a) v->view.place[a] = (double)target[a] + origin[a];
  v->view.size = 0.12 * (double)v->camera.distance;
  v->view.message = v->message;
  v->view.times = stage_times(v->stage, v->edit.field);
  v->view.mesh_times = v->edit.node != NULL ? stage_mesh_times(v->stage, v->edit.node) : 0;
  panel_wishes wishes;
  panel_draw(v->panel, &v->view, &wishes);
  if (wishes.save) save_scene(v);
  if (wishes.picture) save_picture(v);
  if (wishes.home) go_home(v);
  if (wishes.undo) undo(v);
  if (wishes.redo) redo(v);
  glfwSwapBuffers(v->window);
}

static void run(viewer* v) {
  double before = timer_seconds();
  while (!glfwWindowShouldClose(v->window)) {
    /* A finished picture waits for events; an unfinished one looks for them in passing. */
    if (v->still && !edits_wait(v))
      glfwWaitEventsTimeout(0.5);
    else
      glfwPollEvents();
    double now = timer_seconds();
    frame(v, now - before);
    before = now;
  }
}

/* --- Opening --- */

static int show(viewer* v, const scree_jobs* jobs) {
  scree_error error = {""};
  const render_desc desc = {.no_indirect = v->options->no_indirect, .jobs = *jobs};
  scree_result result = render_create(&desc, &v->renderer, &error);
  if (result == SCREE_OK) {
    const stage_desc wanted = {.renderer = v->renderer,
                               .scene = v->scene,
                               .paths = v->options->paths,
                               .jobs = *jobs,
                               .flags = v->options->all_rocks ? 0 : SCREE_SCENE_VISIBLE};
    result = stage_create(&wanted, &v->stage, &error);
  }
  if (result != SCREE_OK) {
    fprintf(stderr, "scree-view: %s\n", error.message[0] != 0 ? error.message : scree_result_string(result));
    return result == SCREE_ERROR_OUT_OF_MEMORY || result == SCREE_ERROR_UNSUPPORTED ? 1 : 2;
  }
  edit_begin(&v->edit, v->scene);
  render_picture_init(&v->picture);
  v->picture.width = v->options->width;
  v->picture.height = v->options->height;
  v->picture.lod = v->options->lod;
  v->picture.pixel_error = v->options->pixel_error;
  v->coarseness = 1;
  v->hot_arrow = -1;
  v->view = (panel_view){.edit = &v->edit,
                         .packs = v->options->paths.packs != NULL ? v->options->paths.packs : SCENE_DEFAULT_PACKS,
                         .panel = !v->options->no_panel,
                         .figures = !v->options->no_panel,
                         .stone_counts = v->stone_counts,
                         .colour = v->options->colour,
                         .wireframe = v->options->wireframe};
  go_home(v);
  count_stones(v);
  for (uint32_t f = 0; f < v->scene->field_count; ++f) log_field(v, "open", f);

  glfwSetWindowUserPointer(v->window, v);
  glfwSetKeyCallback(v->window, on_key);
  glfwSetMouseButtonCallback(v->window, on_button);
  glfwSetCursorPosCallback(v->window, on_pointer);
  glfwSetScrollCallback(v->window, on_wheel);
  v->panel = panel_create(v->window);
  if (v->panel == NULL) return 1;
  run(v);
  return 0;
}

int window_run(const view_options* options, scene_model* scene, const scree_jobs* jobs) {
  viewer* v = calloc(1, sizeof *v);
  if (v == NULL) return 1;
  int status = 1;
  v->options = options;
  v->scene = scene;
  v->window = view_window_open(options, options->paths.scene);
  if (v->window != NULL) {
    v->log = view_log_open(options);
    status = show(v, jobs);
    panel_destroy(v->panel);
    outline_free(&v->outline);
    edit_end(&v->edit);
    stage_destroy(v->stage);
    render_destroy(v->renderer);
    view_log_close(v->log);
    glfwDestroyWindow(v->window);
  }
  free(v);
  glfwTerminate();
  return status;
}
