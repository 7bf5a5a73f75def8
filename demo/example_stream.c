/* scree-example PACK.scree [FRAMES PICTURE.ppm]: an endless field of rock, streamed round a camera that flies over it. Meshes and
 * instances lie in one buffer each, shaders/example.vert reads the stream's structs as they are, and one call draws everything. */
#include <scree/draco.h>
#include <scree/stream.h>
#include <scree/threads.h>
#include <stdlib.h>
#include <string.h>

#include "example_gl.h"

enum { WIDTH = 1280, HEIGHT = 720, BLOCKS = 8192, INSTANCES = 1 << 19, PAGE = 512, PAGES = 1 << 18 };

static struct {
  GLuint meshes, instances, blocks, commands; /* buffers */
  uint32_t levels, pages_used;
  uint32_t given[PAGES], next_given[PAGES]; /* by length: the first of the pages that meshes gave back; 0 = none */
  struct placed_mesh {
    uint32_t page, pages, first_index, index_count; /* vertices, behind them indices */
  } * placed;                                       /* by asset and level */
  scree_event_block shown[BLOCKS];                  /* no instances: not shown */
  float places[BLOCKS][8];                          /* what the shader knows of them: origin relative to the eye, scale, level */
  uint32_t asset[INSTANCES];
  uint8_t level[INSTANCES];
  uint32_t draws[INSTANCES][5]; /* DrawElementsIndirectCommand */
} r;

static void mesh_in(const scree_event_mesh* mesh) {
  const GLsizeiptr vertices = mesh->vertex_count * (GLsizeiptr)sizeof *mesh->vertices, indices = mesh->index_count * 2;
  uint32_t pages = (uint32_t)((vertices + indices + PAGE - 1) / PAGE), page = 1 + r.pages_used;
  if (r.given[pages] == 0 && page + pages <= PAGES) {
    r.pages_used += pages;
  } else {
    while (r.given[pages] == 0)
      if (++pages == PAGES) return; /* no room: it is not placed, and a coarser one is drawn */
    page = r.given[pages];
    r.given[pages] = r.next_given[page];
  }
  glNamedBufferSubData(r.meshes, (GLintptr)page * PAGE, vertices, mesh->vertices);
  glNamedBufferSubData(r.meshes, (GLintptr)page * PAGE + vertices, indices, mesh->indices);
  r.placed[mesh->asset * r.levels + mesh->level] =
      (struct placed_mesh){page, pages, page * (PAGE / 2) + (uint32_t)vertices / 2, mesh->index_count};
}

static void mesh_out(const scree_event_mesh* mesh) {
  struct placed_mesh* placed = &r.placed[mesh->asset * r.levels + mesh->level];
  r.next_given[placed->page] = r.given[placed->pages];
  r.given[placed->pages] = placed->page; /* 0 and 0 if it was not placed */
  *placed = (struct placed_mesh){0};
}

static void block_in(const scree_event_block* block) {
  const GLsizeiptr size = sizeof *block->instances;
  r.shown[block->block] = *block;
  if (block->instances != NULL)
    glNamedBufferSubData(r.instances, block->first_instance * size, block->instance_count * size, block->instances);
  for (uint32_t i = 0; block->instances != NULL && i < block->instance_count; ++i)
    r.asset[block->first_instance + i] = block->instances[i].asset;
  for (uint32_t i = 0; i < block->run_count; ++i)
    memset(&r.level[block->runs[i].first], block->runs[i].level, block->runs[i].count);
}

static void draw(const double eye[3]) {
  GLsizei count = 0;
  for (uint32_t b = 0; b < BLOCKS; ++b) {
    const scree_event_block* block = &r.shown[b];
    for (int axis = 0; axis < 3; ++axis) r.places[b][axis] = (float)(block->origin[axis] - eye[axis]);
    r.places[b][3] = block->scale;
    r.places[b][4] = (float)block->level;
    for (uint32_t i = block->first_instance; i < block->first_instance + block->instance_count; ++i) {
      const struct placed_mesh* mesh = &r.placed[r.asset[i] * r.levels + r.level[i]];
      for (uint32_t level = r.level[i] + 1u; mesh->index_count == 0 && level < r.levels; ++level) ++mesh;
      const uint32_t command[5] = {mesh->index_count, 1, mesh->first_index, mesh->page * (PAGE / 16), i};
      memcpy(r.draws[count++], command, sizeof command);
    }
  }
  glNamedBufferSubData(r.blocks, 0, sizeof r.places, r.places);
  glNamedBufferSubData(r.commands, 0, count * (GLsizeiptr)sizeof *r.draws, r.draws);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, NULL, count, 0);
}

static void prepare(const scree_pack* pack) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  r.levels = info.lod_count;
  r.placed = calloc((size_t)(info.asset_count + info.proxy_count) * info.lod_count, sizeof *r.placed);
  check(r.placed != NULL, "out of memory");
  r.meshes = make_buffer(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)PAGES * PAGE);
  r.instances = make_buffer(GL_SHADER_STORAGE_BUFFER, 1, INSTANCES * (GLsizeiptr)sizeof(scree_stream_instance));
  r.blocks = make_buffer(GL_SHADER_STORAGE_BUFFER, 2, sizeof r.places);
  r.commands = make_buffer(GL_DRAW_INDIRECT_BUFFER, 0, sizeof r.draws);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, r.meshes);
}

int main(int argument_count, char** arguments) {
  check(argument_count == 2 || argument_count == 4, "usage: scree-example PACK.scree [FRAMES PICTURE.ppm]");
  const long frames = argument_count == 4 ? strtol(arguments[2], NULL, 10) : -1; /* -1: no end */
  GLFWwindow* window = open_window(WIDTH, HEIGHT);

  scree_pack* pack;
  check(scree_pack_open_file(arguments[1], NULL, &pack) == SCREE_OK, "no pack");
  scree_field* field;
  check(scree_field_create(&(scree_field_desc){.pack = pack, .seed = 7, .cell_size = 0.8}, NULL, &field) == SCREE_OK, "no field");
  const scree_shape shapes[] = {{.kind = SCREE_SHAPE_NOISE, .noise = {.child = 1, .amplitude = 12, .wavelength = 90, .octaves = 3}},
                                {.kind = SCREE_SHAPE_HALF_SPACE}};
  scree_support* hills;
  check(scree_support_create(&(scree_support_desc){.shapes = shapes, .shape_count = 2}, NULL, &hills, NULL) == SCREE_OK, "no hill");
  const scree_layer layer = {.field = field, .support = hills, .shell_depth = 2.5f};
  scree_scene* scene;
  check(scree_scene_create(&(scree_scene_desc){.layers = &layer, .layer_count = 1}, NULL, &scene, NULL) == SCREE_OK, "no scene");
  scree_threads* pool;
  check(scree_threads_create(1, NULL, &pool) == SCREE_OK, "no threads");
  scree_stream_desc desc = {.scene = scene, .view_distance = 300, .max_error_pixels = 2, .deterministic = frames > 0};
  desc.decode = scree_draco_decode_u16;
  desc.tasks = scree_threads_tasks(pool);
  desc.caps = (scree_stream_caps){.blocks = BLOCKS, .instances = INSTANCES, .mesh_bytes = (uint64_t)PAGES * PAGE * 3 / 4};
  scree_stream* stream;
  scree_error error = {""};
  check(scree_stream_create(&desc, NULL, &stream, &error) == SCREE_OK, error.message);
  prepare(pack);

  for (long frame = 0; frame != frames && !glfwWindowShouldClose(window); ++frame) {
    const double time = frames > 0 ? (double)frame / 60 : glfwGetTime();
    const scree_view view = {.position = {0, 18, -20 * time}, .field_of_view = 1, .viewport_height = HEIGHT};
    const scree_event* events;
    uint32_t count;
    check(scree_stream_update(stream, &view, 1, time, &events, &count) == SCREE_OK, "the stream fails");
    for (const scree_event* event = events; event < events + count; ++event) {
      if (event->kind == SCREE_EVENT_MESH_IN) mesh_in(&event->mesh);
      if (event->kind == SCREE_EVENT_MESH_OUT) mesh_out(&event->mesh);
      if (event->kind == SCREE_EVENT_BLOCK_IN || event->kind == SCREE_EVENT_BLOCK_CHANGE) block_in(&event->block);
      if (event->kind == SCREE_EVENT_BLOCK_OUT) r.shown[event->block.block].instance_count = 0;
    }
    look(view.field_of_view, 0.2f, -0.25f, -1);
    draw(view.position);
    if (frame + 1 == frames) write_picture(arguments[3], WIDTH, HEIGHT);
    glfwSwapBuffers(window);
    glfwPollEvents();
  }
  check(glGetError() == GL_NO_ERROR, "OpenGL found a mistake");
  scree_stream_destroy(stream);
  scree_threads_destroy(pool);
  scree_scene_destroy(scene);
  scree_support_destroy(hills);
  scree_field_destroy(field);
  scree_pack_close(pack);
  free(r.placed);
  glfwTerminate();
  return 0;
}
