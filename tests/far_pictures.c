/* far_pictures PACK.scree [-o PREFIX] [-d METRES] [-s WIDTH HEIGHT] [-c CELL] [-e PIXELS] [-t]: one slope twice, as rocks and as
 * the far field, through the stream and with the example's shaders (without haze), and how the two pictures differ.
 *
 * Both are drawn with four by four samples a pixel. Compared are the pixels that both cover altogether: the mean brightness, and
 * the contrast at scales of 1, 2 and 4 pixels (the standard deviation of what a box filter of that width takes away from one of
 * half the width; at 1, from none). The silhouette: by how many pixels the covered heights of columns
 * differ in the upper half. Holes: what shows through
 * below the silhouette, as a share of what both cover, more with the far field than without.
 * -t: a test. Ends with status 1 where they differ more than the limits below, with 77 where there is no OpenGL 4.5. */
#include <epoxy/gl.h>
#include <math.h>
#include <scree/draco.h>
#include <scree/stream.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "example_program.h"
#include "example_shaders.h"
#include "headless.h"

enum { SAMPLES = 4, BLOCKS = 32768, INSTANCES = 1 << 21, SIDE = 129 };

/* Pixels a radian: a picture 720 pixels high with a field of view of one radian. */
static const double PIXELS = 659;

static void check(bool good, const char* what) {
  if (good) return;
  fprintf(stderr, "far_pictures: %s\n", what);
  exit(1);
}

static struct {
  const char *pack, *prefix;
  double distance, cell, error;
  int width, height;
  bool test;
} given = {.prefix = NULL, .distance = 300, .cell = 0.5, .error = 1, .width = 640, .height = 360};

static void read_arguments(int count, char** list) {
  for (int i = 1; i < count; ++i) {
    if (list[i][0] != '-')
      given.pack = list[i];
    else if (strcmp(list[i], "-t") == 0)
      given.test = true;
    else if (strcmp(list[i], "-o") == 0 && i + 1 < count)
      given.prefix = list[++i];
    else if (strcmp(list[i], "-d") == 0 && i + 1 < count)
      given.distance = atof(list[++i]);
    else if (strcmp(list[i], "-c") == 0 && i + 1 < count)
      given.cell = atof(list[++i]);
    else if (strcmp(list[i], "-e") == 0 && i + 1 < count)
      given.error = atof(list[++i]);
    else if (strcmp(list[i], "-s") == 0 && i + 2 < count) {
      given.width = atoi(list[i + 1]);
      given.height = atoi(list[i + 2]);
      i += 2;
    } else
      check(false, "no such argument");
  }
  check(given.pack != NULL, "usage: far_pictures PACK.scree [-o PREFIX] [-d METRES] [-s WIDTH HEIGHT] [-c CELL] [-e PIXELS] [-t]");
}

/* --- drawing ---------------------------------------------------------------------------------------------------------------- */

typedef struct mesh_place {
  uint32_t vertex, first_index, index_count;
} mesh_place;

typedef struct picture {
  float* light;   /* a pixel: mean brightness of its samples, 0 where nothing is */
  float* covered; /* 0..1 */
  uint8_t* rgb;
  scree_stream_stats stats;
  uint32_t levels[16]; /* instances by the level of their block */
} picture;

static GLuint frame, targets[2], buffers[4]; /* meshes, instances, blocks, indirect */

static void prepare(void) {
  char* vertex = malloc(strlen(shader_example_vert) + 1);
  check(vertex != NULL, "out of memory");
  strcpy(vertex, shader_example_vert);
  char* haze = strstr(vertex, "/ 250.0");
  check(haze != NULL, "example.vert has no haze of 250 m");
  memcpy(haze, "/ 1e9  ", 7);
  char log[1024] = "";
  check(use_example_program(vertex, log, sizeof log) != 0, log);
  free(vertex);
  const int w = given.width * SAMPLES, h = given.height * SAMPLES;
  glCreateTextures(GL_TEXTURE_2D, 2, targets);
  glTextureStorage2D(targets[0], 1, GL_RGBA8, w, h);
  glTextureStorage2D(targets[1], 1, GL_DEPTH_COMPONENT32F, w, h);
  glCreateFramebuffers(1, &frame);
  glNamedFramebufferTexture(frame, GL_COLOR_ATTACHMENT0, targets[0], 0);
  glNamedFramebufferTexture(frame, GL_DEPTH_ATTACHMENT, targets[1], 0);
  glBindFramebuffer(GL_FRAMEBUFFER, frame);
  glViewport(0, 0, w, h);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  const float reach = (float)given.distance, c = (float)(PIXELS * 2); /* looks along -z */
  const float near = reach * 0.25f, far = reach * 6;
  const float camera[16] = {
      c / (float)given.width,        0, 0, 0, 0, c / (float)given.height, 0, 0, 0, 0, (near + far) / (near - far), -1, 0, 0,
      2 * near * far / (near - far), 0};
  glUniformMatrix4fv(0, 1, GL_FALSE, camera);
}

/* Everything that a stream shows at rest. */
static void draw(const scree_scene* scene, const scree_pack* pack, bool far_field, picture* out) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  scree_stream_desc desc = {.scene = scene, .view_distance = given.distance * 6, .max_error_pixels = (float)given.error};
  desc.no_far_field = !far_field;
  desc.decode = scree_draco_decode_u16;
  desc.caps = (scree_stream_caps){
      .blocks = BLOCKS, .instances = INSTANCES, .upload_bytes = 1u << 30, .mesh_bytes = 1u << 30, .events = 1 << 17};
  scree_stream* stream;
  scree_error error = {""};
  check(scree_stream_create(&desc, NULL, &stream, &error) == SCREE_OK, error.message);

  mesh_place* places = calloc((size_t)(info.asset_count + info.proxy_count) * info.lod_count, sizeof *places);
  uint8_t* level = calloc(INSTANCES, 1);
  scree_stream_instance* instances = calloc(INSTANCES, sizeof *instances);
  scree_event_block* shown = calloc(BLOCKS, sizeof *shown);
  size_t room = (size_t)1 << 29, used = 0;
  uint8_t* meshes = malloc(room);
  check(places && level && instances && shown && meshes, "out of memory");
  const scree_view view = {.position = {0, 0, 0},
                           .field_of_view = (float)(2 * atan(given.height * 0.5 / PIXELS)),
                           .viewport_height = (float)given.height};
  for (int update = 0; update < 20000 && !out->stats.complete; ++update) {
    const scree_event* events;
    uint32_t count;
    check(scree_stream_update(stream, &view, 1, update, &events, &count) == SCREE_OK, "the stream fails");
    for (const scree_event* e = events; e < events + count; ++e) {
      if (e->kind == SCREE_EVENT_MESH_IN) {
        const size_t vertices = e->mesh.vertex_count * sizeof *e->mesh.vertices, indices = (e->mesh.index_count * 2 + 15) / 16 * 16;
        check(used + vertices + indices <= room, "too many meshes");
        memcpy(meshes + used, e->mesh.vertices, vertices);
        memcpy(meshes + used + vertices, e->mesh.indices, e->mesh.index_count * 2);
        places[e->mesh.asset * info.lod_count + e->mesh.level] =
            (mesh_place){(uint32_t)(used / 16), (uint32_t)((used + vertices) / 2), e->mesh.index_count};
        used += vertices + indices;
      }
      if (e->kind == SCREE_EVENT_BLOCK_IN || e->kind == SCREE_EVENT_BLOCK_CHANGE) {
        shown[e->block.block] = e->block;
        if (e->block.instances != NULL)
          memcpy(instances + e->block.first_instance, e->block.instances, e->block.instance_count * sizeof *instances);
        for (uint32_t i = 0; i < e->block.run_count; ++i)
          memset(level + e->block.runs[i].first, e->block.runs[i].level, e->block.runs[i].count);
      }
      if (e->kind == SCREE_EVENT_BLOCK_OUT) shown[e->block.block].instance_count = 0;
    }
    scree_stream_get_stats(stream, &out->stats);
  }
  check(out->stats.complete && out->stats.degraded == 0 && out->stats.coarser == 0,
        "the stream does not come to rest within its caps");

  uint32_t(*commands)[5] = malloc(INSTANCES * sizeof *commands);
  float(*blocks)[8] = calloc(BLOCKS, sizeof *blocks);
  check(commands && blocks, "out of memory");
  GLsizei drawn = 0;
  for (uint32_t b = 0; b < BLOCKS; ++b) {
    for (int a = 0; a < 3; ++a) blocks[b][a] = (float)shown[b].origin[a];
    blocks[b][3] = shown[b].scale;
    blocks[b][4] = (float)shown[b].level;
    if (shown[b].instance_count > 0) out->levels[shown[b].level < 16 ? shown[b].level : 15] += shown[b].instance_count;
    for (uint32_t i = shown[b].first_instance; i < shown[b].first_instance + shown[b].instance_count; ++i) {
      const mesh_place* mesh = &places[instances[i].asset * info.lod_count + level[i]];
      const uint32_t command[5] = {mesh->index_count, 1, mesh->first_index, mesh->vertex, i};
      memcpy(commands[drawn++], command, sizeof command);
    }
  }
  const void* data[4] = {meshes, instances, blocks, commands};
  const size_t sizes[4] = {used, INSTANCES * sizeof *instances, BLOCKS * sizeof *blocks, (size_t)drawn * sizeof *commands};
  glCreateBuffers(4, buffers);
  for (GLuint i = 0; i < 4; ++i) {
    glNamedBufferStorage(buffers[i], (GLsizeiptr)sizes[i], data[i], 0);
    if (i < 3) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
  }
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[0]);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, buffers[3]);
  glClearColor(0.62f, 0.73f, 0.85f, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const GLsizei MOST = 1 << 14; /* at once */
  for (GLsizei first = 0; first < drawn; first += MOST)
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, (const void*)((uintptr_t)first * sizeof *commands),
                                drawn - first < MOST ? drawn - first : MOST, 0);
  const int w = given.width, h = given.height, wide = w * SAMPLES;
  uint8_t* samples = malloc((size_t)wide * (size_t)(h * SAMPLES) * 4);
  out->light = calloc((size_t)(w * h), sizeof *out->light);
  out->covered = calloc((size_t)(w * h), sizeof *out->covered);
  out->rgb = malloc((size_t)(w * h) * 3);
  check(samples && out->light && out->covered && out->rgb, "out of memory");
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, wide, h * SAMPLES, GL_RGBA, GL_UNSIGNED_BYTE, samples);
  check(glGetError() == GL_NO_ERROR, "OpenGL found a mistake");
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      double sum[4] = {0, 0, 0, 0}, light = 0; /* samples are averaged as light, not as their codes */
      for (int i = 0; i < SAMPLES * SAMPLES; ++i) {
        const uint8_t* s =
            samples + 4 * ((size_t)((h - 1 - y) * SAMPLES + i / SAMPLES) * (size_t)wide + (size_t)(x * SAMPLES + i % SAMPLES));
        for (int k = 0; k < 3; ++k) sum[k] += pow(s[k] / 255.0, 2.2);
        sum[3] += s[3] > 0;
      }
      for (int k = 0; k < 3; ++k) {
        light += sum[k] / (SAMPLES * SAMPLES * 3);
        out->rgb[3 * (y * w + x) + k] = (uint8_t)(pow(sum[k] / (SAMPLES * SAMPLES), 1 / 2.2) * 255 + 0.5);
      }
      out->light[y * w + x] = (float)pow(light, 1 / 2.2); /* as the eye has it */
      out->covered[y * w + x] = (float)(sum[3] / (SAMPLES * SAMPLES));
    }
  glDeleteBuffers(4, buffers);
  free(samples);
  free(commands);
  free(blocks);
  free(meshes);
  free(shown);
  free(instances);
  free(level);
  free(places);
  scree_stream_destroy(stream);
}

/* --- comparison ------------------------------------------------------------------------------------------------------------- */

/* The mean of a box of pixels, all of which must be in the mask; NAN elsewhere. */
static double box_mean(const picture* p, const uint8_t* mask, int x, int y, int width) {
  double sum = 0;
  for (int j = y; j < y + width; ++j)
    for (int i = x; i < x + width; ++i) {
      if (i >= given.width || j >= given.height || !mask[j * given.width + i]) return (double)NAN;
      sum += (double)p->light[j * given.width + i];
    }
  return sum / (width * width);
}

static double mean_light(const picture* p, const uint8_t* mask) {
  double sum = 0, count = 0;
  for (int i = 0; i < given.width * given.height; ++i)
    if (mask[i]) sum += (double)p->light[i], count += 1;
  return sum / count;
}

/* Contrast between boxes of `width` pixels and those twice as wide around them. */
static double contrast(const picture* p, const uint8_t* mask, int width) {
  double sum = 0, count = 0;
  for (int y = 0; y + 2 * width <= given.height; y += width)
    for (int x = 0; x + 2 * width <= given.width; x += width) {
      double d = box_mean(p, mask, x, y, width) - box_mean(p, mask, x, y, 2 * width);
      if (!isfinite(d)) continue;
      sum += d * d;
      count += 1;
    }
  return sqrt(sum / count);
}

/* Pixels of nothing between the highest and the lowest that is covered, over all columns. */
static double gaps(const picture* p) {
  double sum = 0;
  for (int x = 0; x < given.width; ++x) {
    int low = given.height, high = -1;
    for (int y = 0; y < given.height; ++y)
      if (p->covered[y * given.width + x] == 1) {
        if (high < 0) low = y;
        high = y;
      }
    for (int y = low; y < high; ++y) sum += 1 - (double)p->covered[y * given.width + x];
  }
  return sum;
}

int main(int argument_count, char** arguments) {
  read_arguments(argument_count, arguments);
  headless* gl;
  scree_error error = {""};
  if (headless_create(&gl, &error) != SCREE_OK || epoxy_gl_version() < 45) {
    fprintf(stderr, "far_pictures: no OpenGL 4.5: %s\n", error.message);
    return 77;
  }
  prepare();
  scree_pack* pack;
  check(scree_pack_open_file(given.pack, NULL, &pack) == SCREE_OK, "no pack");
  scree_field* field;
  check(scree_field_create(&(scree_field_desc){.pack = pack, .seed = 7, .cell_size = given.cell}, NULL, &field) == SCREE_OK,
        "no field");
  /* A slope that rises away from the eye and fills the picture but for some sky: 36 degrees, with hollows. */
  static float heights[SIDE * SIDE];
  const double across = given.distance * given.width / PIXELS * 1.4, up = given.distance * given.height / PIXELS;
  const double spacing = across / (SIDE - 1), depth = up * 1.1;
  const uint32_t rows = (uint32_t)fmin(SIDE, ceil(depth / spacing) + 2);
  for (uint32_t k = 0; k < rows; ++k)
    for (uint32_t i = 0; i < SIDE; ++i) {
      double x = (i - (SIDE - 1) * 0.5) * spacing / up, z = -(k - (rows - 1) * 0.5) * spacing / up; /* z: away from the eye */
      heights[k * SIDE + i] =
          (float)(up * (0.72 * z - 0.05 + 0.06 * sin(9 * x + 2 * z) * cos(7 * z - 3 * x) + 0.02 * sin(31 * x) * sin(27 * z)));
    }
  const scree_shape slope = {.kind = SCREE_SHAPE_HEIGHTFIELD,
                             .transform = {.translation = {0, 0, (float)-(given.distance + depth * 0.5)}},
                             .heightfield = {heights, SIDE, rows, (float)spacing, 0, (float)(3 * given.cell)}};
  scree_support* support;
  check(scree_support_create(&(scree_support_desc){.shapes = &slope, .shape_count = 1}, NULL, &support, &error) == SCREE_OK,
        error.message);
  const scree_layer layer = {.field = field, .support = support};
  scree_scene* scene;
  check(scree_scene_create(&(scree_scene_desc){.layers = &layer, .layer_count = 1}, NULL, &scene, &error) == SCREE_OK,
        error.message);

  picture pictures[2] = {{.light = NULL}, {.light = NULL}};
  const char* names[2] = {"rocks", "far"};
  for (int i = 0; i < 2; ++i) {
    draw(scene, pack, i == 1, &pictures[i]);
    char path[4096];
    snprintf(path, sizeof path, "%s_%s.png", given.prefix ? given.prefix : "", names[i]);
    if (given.prefix)
      check(picture_write(path, (uint32_t)given.width, (uint32_t)given.height, pictures[i].rgb, &error) == SCREE_OK, error.message);
    printf("%s: %u instances, %u of them proxies, %llu triangles; by level of block:", names[i], pictures[i].stats.instances,
           pictures[i].stats.proxies, (unsigned long long)pictures[i].stats.triangles);
    for (int k = 0; k < 16; ++k)
      if (pictures[i].levels[k] > 0) printf(" %d: %u", k, pictures[i].levels[k]);
    printf("\n");
  }
  uint8_t* mask = calloc((size_t)(given.width * given.height), 1);
  check(mask != NULL, "out of memory");
  double silhouette = 0, both = 0;
  for (int x = 0; x < given.width; ++x) {
    double tall[2] = {0, 0};
    for (int y = 0; y < given.height; ++y) {
      int i = y * given.width + x;
      mask[i] = pictures[0].covered[i] == 1 && pictures[1].covered[i] == 1;
      both += mask[i];
      for (int k = 0; k < 2 && y < given.height / 2; ++k) tall[k] += (double)pictures[k].covered[i];
    }
    silhouette += fabs(tall[1] - tall[0]) / given.width;
  }
  check(both > 0.3 * given.width * given.height, "the slope does not fill the picture");
  const double holes = (gaps(&pictures[1]) - gaps(&pictures[0])) / both;
  const double light[2] = {mean_light(&pictures[0], mask), mean_light(&pictures[1], mask)};
  printf("distance %g m, cell %g m, error %g px, %d x %d\n", given.distance, given.cell, given.error, given.width, given.height);
  printf("brightness %.4f %.4f ratio %.3f\n", light[0], light[1], light[1] / light[0]);
  bool good = fabs(light[1] / light[0] - 1) < 0.05 && silhouette < 2 && holes < 0.05;
  for (int width = 1; width <= 4; width *= 2) {
    const double c[2] = {contrast(&pictures[0], mask, width), contrast(&pictures[1], mask, width)};
    printf("contrast at %d px %.4f %.4f ratio %.3f\n", width, c[0], c[1], c[1] / c[0]);
    good = good && c[1] / c[0] > 0.75 && c[1] / c[0] < 1.33;
  }
  printf("silhouette differs by %.3f px, holes %.5f\n", silhouette, holes);
  for (int i = 0; i < 2; ++i) {
    free(pictures[i].light);
    free(pictures[i].covered);
    free(pictures[i].rgb);
  }
  free(mask);
  scree_scene_destroy(scene);
  scree_support_destroy(support);
  scree_field_destroy(field);
  scree_pack_close(pack);
  headless_destroy(gl);
  return given.test && !good;
}
