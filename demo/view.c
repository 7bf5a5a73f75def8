/* scree-view: a scene in a window, or as one picture without a display. */
#include <epoxy/gl.h>
#include <scree/threads.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "headless.h"
#include "stage.h"
#include "timer.h"
#include "view_window.h"
#ifdef SCREE_WITH_BAKE
#include "weather_session.h"
#include "weather_view.h"
#endif
#include "window.h"

static int fail(scree_result result, const char* message) {
  fprintf(stderr, "scree-view: %s\n", message[0] != 0 ? message : scree_result_string(result));
  return result == SCREE_ERROR_OUT_OF_MEMORY || result == SCREE_ERROR_UNSUPPORTED ? 1 : 2;
}

/* Writes the picture; the renderer's context is current. */
static int take_picture(const view_options* options, const scene_model* scene, const scree_jobs* jobs, render* r) {
  scree_error error = {""};
  const stage_desc desc = {
      .renderer = r, .scene = scene, .paths = options->paths, .jobs = *jobs, .flags = options->all_rocks ? 0 : SCREE_SCENE_VISIBLE};
  double start = timer_seconds();
  stage* s;
  scree_result result = stage_create(&desc, &s, &error);
  if (result != SCREE_OK) return fail(result, error.message);
  double ready = timer_seconds();

  render_picture picture;
  render_picture_init(&picture);
  stage_light(s, &picture);
  camera eye;
  if (options->has_camera)
    stage_camera(s, options->eye, options->target, options->field_of_view, &eye);
  else
    stage_camera(s, scene->camera.eye, scene->camera.target, scene->camera.fov, &eye);
  view_look(&eye, &picture);
  picture.width = options->width;
  picture.height = options->height;
  picture.samples = options->samples > 0 ? options->samples : 8;
  picture.lod = options->lod;
  picture.colour = options->colour;
  picture.wireframe = options->wireframe;
  picture.pixel_error = options->pixel_error;

  result = render_draw(r, &picture);
  int status;
  if (result != SCREE_OK) {
    status = fail(result, "");
  } else {
    glFinish();
    double drawn = timer_seconds();
    const char* file;
    result = view_picture_save(options, r, &picture, &file, &error);
    status = result == SCREE_OK ? 0 : (fail(result, error.message), 1);
    render_stats stats;
    render_get_stats(r, &stats);
    FILE* log = view_log_open(options);
    if (log != NULL)
      fprintf(log,
              "picture instances=%u drawn=%u draws=%u triangles=%llu shadow_triangles=%llu meshes=%u mesh_megabytes=%.1f "
              "samples=%u query_seconds=%.3f draw_seconds=%.3f indirect=%d\n",
              stats.stones, stats.stones_drawn, stats.draws, (unsigned long long)stats.triangles,
              (unsigned long long)stats.shadow_triangles, stats.meshes, (double)stats.mesh_bytes * 1e-6, stats.samples,
              ready - start, drawn - ready, stats.indirect);
    view_log_close(log);
  }
  stage_destroy(s);
  return status;
}

static int run_headless(const view_options* options, const scene_model* scene, const scree_jobs* jobs) {
  scree_error error = {""};
  headless* context;
  scree_result result = headless_create(&context, &error);
  if (result != SCREE_OK) return fail(result, error.message);
  const render_desc desc = {.no_indirect = options->no_indirect, .jobs = *jobs};
  render* r;
  int status;
  result = render_create(&desc, &r, &error);
  if (result != SCREE_OK) {
    status = fail(result, error.message);
  } else {
    status = take_picture(options, scene, jobs, r);
    render_destroy(r);
  }
  headless_destroy(context);
  return status;
}

/* The scene that is given may be a recipe to weather. Returns -1 to go on, else the exit status. */
static int weathers(view_options* options) {
#ifdef SCREE_WITH_BAKE
  if (options->weather == NULL && weather_recipe_is(options->paths.scene)) view_options_weather(options);
#else
  if (options->weather != NULL) return fail(SCREE_ERROR_UNSUPPORTED, "--weather: this build was made without the baker");
#endif
  return view_options_check(options);
}

static int show(const view_options* options, scene_model* scene, const scree_jobs* jobs) {
#ifdef SCREE_WITH_BAKE
  if (options->weather != NULL) return weather_view_run(options, jobs);
#endif
  return options->headless ? run_headless(options, scene, jobs) : window_run(options, scene, jobs);
}

int main(int count, char** arguments) {
  view_options options;
  int status = view_options_parse(count, arguments, &options);
  if (status >= 0) return status;
  status = weathers(&options);
  if (status >= 0) return status;
  scene_model scene = {0};
  scree_error error = {""};
  scree_result result = options.weather == NULL ? scene_load(options.paths.scene, &scene, &error) : SCREE_OK;
  if (result != SCREE_OK) return fail(result, error.message);
  if (options.headless) result = file_replace_check(options.screenshot, &error);
  const bool logs_to_file = options.log != NULL && strcmp(options.log, "-") != 0;
  if (result == SCREE_OK && logs_to_file) result = file_replace_check(options.log, &error);
  scree_threads* pool = NULL;
  if (result == SCREE_OK) result = scree_threads_create(scree_threads_processors() - 1, NULL, &pool);
  if (result != SCREE_OK) {
    scene_destroy(&scene);
    return fail(result, error.message);
  }
  const scree_jobs jobs = scree_threads_jobs(pool);
  status = show(&options, &scene, &jobs);
  scree_threads_destroy(pool);
  scene_destroy(&scene);
  return status;
}
