/* Packs of cliffs: what is written is what is read, edges of cuts stay sharp, and what is no cliff gives a result code. */
#include <scree/draco.h>
#include <scree/field.h>
#include <scree/scatter.h>

#include "draco_encode.h"
#include "failing_allocator.h"
#include "lattice.h"
#include "make_model_pack.h"
#include "mesh_normals.h"
#include "pack_bytes.h"
#include "pack_writer.h"
#include "plain_encode.h"
#include "plain_mesh.h"
#include "uv_bytes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const test_models_desc several = {.variants = 4, .ages = 3, .lod_count = 2, .cliff = true};
enum { BLOCKS = 3, ASSETS = 3 + BLOCKS, PLACEMENTS = 3 * TEST_PLACEMENTS };

static void what_is_written_is_what_is_read(void** state) {
  (void)state;
  rock_set* set = test_model_set_make(&several);
  uint8_t* bytes;
  size_t size;
  assert_int_equal(pack_write(set, NULL, &bytes, &size), SCREE_OK);
  scree_pack* pack = open_or_fail(bytes, size);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  assert_int_equal(info.kind, SCREE_PACK_CLIFF);
  assert_true(info.variant_count == 1 + BLOCKS && info.time_count == 3 && info.asset_count == ASSETS);
  assert_int_equal(info.placement_count, PLACEMENTS);
  assert_memory_equal(info.uv_min, set->cliff->uvs.min, sizeof info.uv_min);
  assert_memory_equal(info.uv_max, set->cliff->uvs.max, sizeof info.uv_max);
  for (uint32_t t = 0; t < 3; ++t) {
    scree_cliff_time time;
    assert_int_equal(scree_pack_get_time(pack, t, &time), SCREE_OK);
    assert_true(time.asset == scree_pack_model(pack, 0, t) && time.asset == t);
    assert_true(time.paths == set->models[t].steps && time.share == set->models[t].share);
    assert_int_equal(time.first_placement, set->cliff->placement_first[t]);
    assert_int_equal(time.placement_count, TEST_PLACEMENTS * t);
    /* The same placements, in another order. */
    scree_block_placement read[2 * TEST_PLACEMENTS];
    assert_int_equal(scree_pack_get_placements(pack, time.first_placement, time.placement_count, read), SCREE_OK);
    bool taken[2 * TEST_PLACEMENTS] = {false};
    for (uint32_t i = 0; i < time.placement_count; ++i) {
      const scree_block_placement* from = &set->cliff->placements[time.first_placement];
      uint32_t k = 0;
      while (k < time.placement_count && (taken[k] || memcmp(&read[k], &from[i], sizeof *read) != 0)) ++k;
      assert_true(k < time.placement_count);
      taken[k] = true;
      if (i > 0) assert_true(scree_rt_pack_place_code(read[i - 1].translation) <= scree_rt_pack_place_code(read[i].translation));
    }
  }
  for (uint32_t block = 1; block <= BLOCKS; ++block) {
    scree_model model;
    const uint32_t asset = scree_pack_model(pack, block, 0);
    assert_int_equal(asset, 2 + block);
    assert_int_equal(scree_pack_model(pack, block, 1), UINT32_MAX);
    assert_int_equal(scree_pack_get_model(pack, asset, &model), SCREE_OK);
    assert_true(model.variant == block && model.age == 0 && model.part_count == 2);
  }
  static const char* const names[3] = {"placements", "times", "uvs"};
  for (uint32_t i = 0; i < 3; ++i) {
    scree_pack_section section;
    assert_int_equal(scree_pack_get_section(pack, 11 + i, &section), SCREE_OK);
    assert_string_equal(section.name, names[i]);
  }
  scree_pack_close(pack);
  free(bytes);
  test_model_set_free(set);
}

static void near_placements_are_near_in_the_file(void** state) {
  (void)state;
  /* Morton order: bits of x, y and z in turn, from 1/128 m on. */
  assert_true(scree_rt_pack_place_code((const float[3]){-4096, -4096, -4096}) == 0);
  assert_true(scree_rt_pack_place_code((const float[3]){-4096 + 1.0f / 128, -4096, -4096}) == 1);
  assert_true(scree_rt_pack_place_code((const float[3]){-4096, -4096 + 1.0f / 128, -4096}) == 2);
  assert_true(scree_rt_pack_place_code((const float[3]){-4096, -4096, -4096 + 3.0f / 128}) == 4 + 32);
  assert_true(scree_rt_pack_place_code((const float[3]){4096, 4096, 4096}) == UINT64_C(7) << 60);
  uint64_t random = 3;
  for (int turn = 0; turn < 1000; ++turn) {
    uint64_t expected = 0, steps[3];
    float place[3];
    for (int axis = 0; axis < 3; ++axis) {
      steps[axis] = (random = hash_mix(random + 1)) % (1 << 20);
      place[axis] = (float)((double)steps[axis] / 128 - 4096);
      for (int bit = 0; bit < 20; ++bit) expected |= (steps[axis] >> bit & 1) << (3 * bit + axis);
    }
    assert_true(scree_rt_pack_place_code(place) == expected);
  }
}

static void bounds_of_a_time_hold_all_its_blocks(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&several, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  for (uint32_t t = 0; t < 3; ++t) {
    scree_cliff_time time;
    assert_int_equal(scree_pack_get_time(pack, t, &time), SCREE_OK);
    float low[3] = {1e9f, 1e9f, 1e9f}, high[3] = {-1e9f, -1e9f, -1e9f};
    for (uint32_t i = 0; i < time.placement_count; ++i) {
      scree_block_placement at;
      assert_int_equal(scree_pack_get_placements(pack, time.first_placement + i, 1, &at), SCREE_OK);
      int16_t hull[PACK_MAX_HULL][3];
      uint32_t count;
      assert_int_equal(scree_pack_get_hull(pack, at.asset, hull[0], PACK_MAX_HULL, &count), SCREE_OK);
      for (uint32_t k = 0; k < count; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
          const float place = at.translation[axis] + (float)hull[k][axis] / (float)info.lattice_per_cell;
          low[axis] = fminf(low[axis], place);
          high[axis] = fmaxf(high[axis], place);
        }
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (t == 0) assert_true(time.bounds_min[axis] == 0 && time.bounds_max[axis] == 0);
      if (t > 0) assert_true(time.bounds_min[axis] <= low[axis] && time.bounds_min[axis] > low[axis] - 3);
      if (t > 0) assert_true(time.bounds_max[axis] >= high[axis] && time.bounds_max[axis] < high[axis] + 3);
    }
  }
  scree_pack_close(pack);
  free(bytes);
}

static void uvs_and_groups_come_back_from_both_codecs(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&several, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  for (uint32_t i = 0; i < info.asset_count; ++i)
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) {
      scree_lod level;
      assert_int_equal(scree_pack_get_lod(pack, i, lod, &level), SCREE_OK);
      const size_t index_count = 3 * (size_t)level.triangles;
      scree_vertex* vertices = malloc(level.vertices * sizeof *vertices);
      uint32_t* indices = malloc(index_count * sizeof *indices);
      scree_uv* uvs = malloc(level.vertices * sizeof *uvs);
      uint8_t* groups = malloc(level.vertices);
      assert_int_equal(scree_draco_decode_u32(pack, i, lod, vertices, level.vertices, indices, index_count), SCREE_OK);
      assert_int_equal(scree_draco_decode_uvs(pack, i, lod, uvs, groups, level.vertices), SCREE_OK);
      assert_true(scree_cliff_mesh_digest(vertices, uvs, groups, level.vertices, indices, level.triangles) == level.digest);
      for (uint32_t v = 0; v < level.vertices; ++v) {
        const scree_vertex* at = &vertices[v];
        if (i < 3) {
          assert_int_equal(groups[v], (at->position[0] > 0) | (at->position[1] > 20) << 1 | (at->position[2] > 0) << 2);
          assert_int_equal(uvs[v].u, uv_value((float)at->position[0] / 40, info.uv_min[0], info.uv_max[0]));
          assert_int_equal(uvs[v].v, uv_value(1 + (float)at->position[2] / 40, info.uv_min[1], info.uv_max[1]));
          continue;
        }
        if (i + 1 == info.asset_count) continue;
        /* Blocks: each face of a cube has its own vertices, and its normals are those of the face alone. */
        assert_int_equal(at->material, 2);
        const int axis = (groups[v] - 1) / 2;
        for (int k = 0; k < 3; ++k) assert_int_equal(at->normal[k], k == axis ? (groups[v] % 2 == 0 ? 32767 : -32767) : 0);
        assert_true(at->position[axis] * at->normal[axis] > 0);
        const int half = abs(at->position[0]);
        assert_true(uvs[v].u == uv_value((float)half / 16, -1, 1) || uvs[v].u == uv_value((float)-half / 16, -1, 1));
      }
      if (i >= 3) assert_int_equal(level.vertices, 24);
      scree_uv again[1 << 12];
      assert_int_equal(scree_draco_decode_uvs(pack, i, lod, again, NULL, 1 << 12), SCREE_OK);
      assert_memory_equal(again, uvs, level.vertices * sizeof *uvs);
      assert_int_equal(scree_draco_decode_uvs(pack, i, lod, again, NULL, level.vertices - 1), SCREE_ERROR_CAPACITY);
      assert_int_equal(scree_draco_decode_uvs(pack, i, lod, NULL, NULL, level.vertices), SCREE_ERROR_INVALID_ARGUMENT);
      if (lod + 1 == info.lod_count) {
        uint8_t* twice = malloc(level.vertices);
        assert_int_equal(scree_pack_coarse_uvs(pack, i, again, twice, level.vertices), SCREE_OK);
        assert_memory_equal(again, uvs, level.vertices * sizeof *uvs);
        assert_memory_equal(twice, groups, level.vertices);
        assert_int_equal(scree_pack_coarse_uvs(pack, i, again, twice, level.vertices - 1), SCREE_ERROR_CAPACITY);
        free(twice);
      }
      free(groups);
      free(uvs);
      free(indices);
      free(vertices);
    }
  scree_pack_close(pack);
  free(bytes);
}

/* Sums over all triangles with a corner at the place and of the group of a vertex. */
static void normal_of(const scree_vertex* vertices, const uint8_t* groups, const uint32_t* indices, uint32_t triangles, uint32_t v,
                      int16_t normal[3]) {
  int64_t sum[3] = {0};
  for (uint32_t i = 0; i < 3 * triangles; ++i) {
    if (memcmp(vertices[indices[i]].position, vertices[v].position, 6) != 0 || groups[indices[i]] != groups[v]) continue;
    const uint32_t* corner = indices + i / 3 * 3;
    const int16_t *a = vertices[corner[0]].position, *b = vertices[corner[1]].position, *c = vertices[corner[2]].position;
    for (int k = 0; k < 3; ++k) {
      const int x = (k + 1) % 3, y = (k + 2) % 3;
      sum[k] += (int64_t)(b[x] - a[x]) * (c[y] - a[y]) - (int64_t)(b[y] - a[y]) * (c[x] - a[x]);
    }
  }
  scree_rt_mesh_normal(sum, normal);
}

static void vertices_share_their_normal_by_place_and_group(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&several, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  static scree_vertex vertices[4096];
  static uint32_t indices[3 * 8192];
  static scree_uv uvs[4096];
  static uint8_t groups[4096];
  uint32_t slanted = 0;
  for (uint32_t i = 0; i < ASSETS; ++i)
    for (uint32_t lod = 0; lod < 2; ++lod) {
      scree_lod level;
      assert_int_equal(scree_pack_get_lod(pack, i, lod, &level), SCREE_OK);
      assert_int_equal(scree_draco_decode_u32(pack, i, lod, vertices, 4096, indices, 3 * 8192), SCREE_OK);
      assert_int_equal(scree_draco_decode_uvs(pack, i, lod, uvs, groups, 4096), SCREE_OK);
      for (uint32_t v = 0; v < level.vertices; ++v) {
        int16_t normal[3];
        normal_of(vertices, groups, indices, level.triangles, v, normal);
        assert_memory_equal(normal, vertices[v].normal, sizeof normal);
        slanted += i + 1 == ASSETS && normal[0] != 0 && normal[1] != 0 && normal[2] != 0;
      }
    }
  assert_int_equal(slanted, 2 * 24); /* the smooth cube's corners, though each face has UVs of its own */
  scree_pack_close(pack);
  free(bytes);
}

/* More vertices than are summed at once, and few places: every vertex shares its normal with others far away in the mesh. */
static void coarse_normals_are_shared_across_batches(void** state) {
  (void)state;
  enum { VERTICES = 1000, TRIANGLES = 3000 };
  static int16_t positions[VERTICES][3];
  static uint8_t occlusion[VERTICES], surface[VERTICES][4];
  static float uvs[VERTICES][2];
  static uint32_t indices[3 * TRIANGLES];
  uint64_t random = 1;
  for (uint32_t v = 0; v < VERTICES; ++v) {
    random = hash_mix(random + 1);
    for (int axis = 0; axis < 3; ++axis) positions[v][axis] = (int16_t)((random >> (8 * axis)) % 7 * 1000);
    surface[v][2] = 128;
    surface[v][3] = (uint8_t)(random >> 40) % 3;
  }
  for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) indices[i] = (uint32_t)((random = hash_mix(random + 1)) % VERTICES);
  const lattice_mesh mesh = {.positions = positions,
                             .occlusion = occlusion,
                             .indices = indices,
                             .surface = surface,
                             .uvs = uvs,
                             .vertex_count = VERTICES,
                             .triangle_count = TRIANGLES};
  rock_lod level;
  assert_int_equal(plain_encode(&mesh, NULL, &level), SCREE_OK);
  plain_mesh read;
  assert_true(scree_rt_plain_mesh_read(level.blob, level.blob_size, VERTICES, TRIANGLES, SCREE_PACK_CLIFF, &read));
  static scree_vertex plain[VERTICES], joined[VERTICES];
  static uint32_t again[3 * TRIANGLES];
  scree_rt_plain_mesh_decode(&read, plain, again, sizeof *again);
  assert_memory_equal(again, indices, sizeof indices);
  memcpy(joined, plain, sizeof plain);
  static uint8_t groups[VERTICES];
  for (uint32_t v = 0; v < VERTICES; ++v) {
    groups[v] = surface[v][3];
    memset(joined[v].normal, 0, sizeof joined[v].normal);
  }
  void* scratch = malloc(scree_rt_joined_normals_scratch(VERTICES));
  scree_rt_joined_normals(joined, groups, VERTICES, indices, TRIANGLES, scratch);
  free(scratch);
  for (uint32_t v = 0; v < VERTICES; ++v) {
    int16_t normal[3];
    normal_of(plain, groups, indices, TRIANGLES, v, normal);
    assert_memory_equal(normal, plain[v].normal, sizeof normal);
    assert_memory_equal(normal, joined[v].normal, sizeof normal);
  }
  free(level.blob);
}

static void uvs_go_to_the_nearest_value_of_the_range(void** state) {
  (void)state;
  assert_int_equal(uv_value(-1, -1, 3), 0);
  assert_int_equal(uv_value(3, -1, 3), 65535);
  assert_int_equal(uv_value(1, -1, 3), 32768);
  assert_int_equal(uv_value(-7, -1, 3), 0);
  assert_int_equal(uv_value(7, -1, 3), 65535);
  assert_int_equal(uv_value(2, 2, 2), 0);
  assert_int_equal(uv_value((float)NAN, -1, 3), 0);
  for (uint32_t value = 0; value < 65536; ++value)
    assert_int_equal(uv_value((float)(-2 + 5 * (double)value / 65535), -2, 3), value);
}

static void digest_of_a_cliffs_mesh_is_what_the_format_says_and_sees_uvs_and_groups(void** state) {
  (void)state;
  const scree_vertex v[4] = {{.occlusion = 0, .durability = 64},
                             {{10, 0, 0}, 85, 16, {0}, 0, -127},
                             {{0, 10, 0}, 170, 33, {0}, 255, 127},
                             {{0, 0, 10}, 255, 2, {0}, 128, -28}};
  scree_uv uvs[4] = {{0, 0}, {65535, 1}, {2, 65534}, {32768, 100}};
  uint8_t groups[4] = {0, 1, 255, 7};
  const uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  const uint64_t digest = scree_cliff_mesh_digest(v, uvs, groups, 4, indices, 4);
  assert_true(digest == UINT64_C(0x9808a4c35f9c6008));
  groups[3] = 6;
  assert_true(scree_cliff_mesh_digest(v, uvs, groups, 4, indices, 4) != digest);
  groups[3] = 7;
  uvs[2].u = 3;
  assert_true(scree_cliff_mesh_digest(v, uvs, groups, 4, indices, 4) != digest);
  uvs[2].u = 2;
  uvs[3].v = 101;
  assert_true(scree_cliff_mesh_digest(v, uvs, groups, 4, indices, 4) != digest);
  uvs[3].v = 100;
  assert_true(scree_cliff_mesh_digest(v, uvs, groups, 4, indices, 4) == digest);
  assert_true(scree_cliff_mesh_digest(v, uvs, groups, 3, indices, 4) == 0);
}

static void what_needs_another_kind_refuses_a_cliff(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&several, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  scree_field* field;
  assert_int_equal(scree_field_create(&(scree_field_desc){.pack = pack, .cell_size = 1}, NULL, &field), SCREE_ERROR_PACK_KIND);
  scree_scatter* scatter;
  scree_error error = {""};
  assert_int_equal(scree_scatter_create(&(scree_scatter_desc){.pack = pack, .spacing = 3}, NULL, &scatter, &error),
                   SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "cliff"));
  uint32_t value;
  assert_int_equal(scree_pack_tile_cell(pack, 0, 0, 0, 0, &value), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_proxy(pack, 0, 0), UINT32_MAX);
  /* And what is not there. */
  scree_cliff_time time;
  scree_block_placement at;
  assert_int_equal(scree_pack_get_time(pack, 3, &time), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_time(pack, 0, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_time(NULL, 0, &time), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_placements(pack, PLACEMENTS, 0, NULL), SCREE_OK);
  assert_int_equal(scree_pack_get_placements(pack, PLACEMENTS, 1, &at), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_placements(pack, 1, UINT32_MAX, &at), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_placements(pack, 0, 1, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_draco_decode_uvs(pack, ASSETS, 0, NULL, NULL, 0), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_coarse_uvs(pack, ASSETS, NULL, NULL, 0), SCREE_ERROR_INVALID_ARGUMENT);
  scree_pack_close(pack);
  free(bytes);
}

static void what_needs_a_cliff_refuses_another_kind(void** state) {
  (void)state;
  for (int models = 0; models < 2; ++models) {
    size_t size;
    uint8_t* bytes = models ? test_model_pack_make(NULL, &size) : test_pack_make(NULL, &size);
    scree_pack* pack = open_or_fail(bytes, size);
    scree_cliff_time time;
    scree_uv uvs[1];
    assert_int_equal(scree_pack_get_time(pack, 0, &time), SCREE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(scree_pack_get_placements(pack, 0, 0, NULL), SCREE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(scree_pack_coarse_uvs(pack, 0, uvs, NULL, 1), SCREE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(scree_draco_decode_uvs(pack, 0, 0, uvs, NULL, 1), SCREE_ERROR_INVALID_ARGUMENT);
    scree_pack_info info;
    scree_pack_get_info(pack, &info);
    assert_true(info.time_count == 0 && info.placement_count == 0 && info.uv_min[0] == 0 && info.uv_max[1] == 0);
    scree_pack_section section;
    assert_int_equal(scree_pack_get_section(pack, models ? 10 : 8, &section), SCREE_OK);
    assert_int_equal(scree_pack_get_section(pack, models ? 11 : 9, &section), SCREE_ERROR_INVALID_ARGUMENT);
    scree_pack_close(pack);
    free(bytes);
  }
}

static void a_cliff_from_which_nothing_fell_is_a_pack(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&(test_models_desc){.variants = 1, .ages = 1, .lod_count = 1, .cliff = true}, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_cliff_time time;
  assert_int_equal(scree_pack_get_time(pack, 0, &time), SCREE_OK);
  assert_int_equal(time.placement_count, 0);
  scree_pack_close(pack);
  free(bytes);
}

/* Everything that a pack of a cliff offers; that the calls return is what counts. */
static void walk(const scree_pack* pack) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  static scree_vertex vertices[4096];
  static uint16_t indices[3 * 8192];
  static scree_uv uvs[4096];
  static uint8_t groups[4096];
  for (uint32_t i = 0; i < info.asset_count && i < 100; ++i) {
    scree_model model;
    scree_pack_get_model(pack, i, &model);
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) {
      scree_draco_decode_u16(pack, i, lod, vertices, 4096, indices, 3 * 8192);
      scree_draco_decode_uvs(pack, i, lod, uvs, groups, 4096);
    }
  }
  for (uint32_t t = 0; t < info.time_count; ++t) {
    scree_cliff_time time;
    scree_block_placement at;
    if (scree_pack_get_time(pack, t, &time) != SCREE_OK) continue;
    assert_true((uint64_t)time.first_placement + time.placement_count <= info.placement_count);
    for (uint32_t i = 0; i < time.placement_count; ++i)
      if (scree_pack_get_placements(pack, time.first_placement + i, 1, &at) == SCREE_OK)
        assert_true(at.asset >= info.time_count && at.asset < info.asset_count);
  }
}

static void every_flipped_byte_is_found_by_open_or_verify(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&(test_models_desc){.variants = 2, .ages = 2, .lod_count = 1, .cliff = true}, &size);
  for (size_t i = 0; i < size; ++i) {
    bytes[i] ^= 1;
    scree_pack* pack;
    if (scree_pack_open_memory(bytes, size, NULL, &pack) == SCREE_OK) {
      if (i % 8 == 0) walk(pack);
      assert_int_equal(scree_pack_verify(pack), SCREE_ERROR_DIGEST);
      scree_pack_close(pack);
    }
    bytes[i] ^= 1;
  }
  free(bytes);
}

static void every_truncation_is_rejected(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&(test_models_desc){.variants = 2, .ages = 2, .lod_count = 1, .cliff = true}, &size);
  for (size_t length = 0; length < size; length += length < 2048 || length + 512 > size ? 1 : 13) {
    uint8_t* cut = malloc(length > 0 ? length : 1);
    memcpy(cut, bytes, length);
    scree_pack* pack;
    assert_int_equal(scree_pack_open_memory(cut, length, NULL, &pack), SCREE_ERROR_TRUNCATED);
    free(cut);
  }
  free(bytes);
}

static void changed_bytes_with_digests_to_match_never_crash_a_reader(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&(test_models_desc){.variants = 2, .ages = 2, .cliff = true}, &size);
  uint8_t* changed = malloc(size);
  const size_t new_sections = (size_t)section_of(bytes, PACK_PLACEMENTS)->offset;
  uint64_t random = 7;
  uint32_t opened = 0, refused = 0;
  for (size_t i = 0; i < size; i += i < 1024 || i >= new_sections ? 1 : 23)
    for (int turn = 0; turn < 2; ++turn) {
      memcpy(changed, bytes, size);
      changed[i] = turn == 0 ? 0xff : (uint8_t)(random = hash_mix(random + 1));
      if (i < sizeof(pack_header) && i >= 12 && i < 24) continue; /* counts that the sealing itself goes by */
      test_pack_reseal(changed);
      scree_pack* pack;
      if (scree_pack_open_memory(changed, size, NULL, &pack) != SCREE_OK) {
        ++refused;
        continue;
      }
      ++opened;
      walk(pack);
      scree_pack_verify(pack);
      scree_pack_close(pack);
    }
  assert_true(opened > 1000 && refused > 50);
  free(changed);
  free(bytes);
}

#define RECORD(type, kind) ((type*)(void*)(bytes + section_of(bytes, kind)->offset))
/* Changes a number of a fresh pack and says what opening, or else verifying, makes of it. */
#define BAD(change)                                                         \
  do {                                                                      \
    size_t size;                                                            \
    uint8_t* bytes = test_model_pack_make(&several, &size);                 \
    change;                                                                 \
    test_pack_reseal(bytes);                                                \
    scree_pack* pack;                                                       \
    scree_result result = scree_pack_open_memory(bytes, size, NULL, &pack); \
    if (result == SCREE_OK) result = scree_pack_verify(pack);               \
    assert_int_equal(result, SCREE_ERROR_CORRUPT);                          \
    scree_pack_close(pack);                                                 \
    free(bytes);                                                            \
  } while (0)

#define FIRST_PLACEMENT RECORD(pack_placement, PACK_PLACEMENTS)
#define TIME RECORD(pack_time, PACK_TIMES)

static void numbers_that_cannot_be_are_corrupt(void** state) {
  (void)state;
  BAD(header_of(bytes)->kind = 3);
  BAD(header_of(bytes)->kind = SCREE_PACK_MODELS);
  BAD(section_of(bytes, PACK_UVS)->kind = 99);
  BAD(FIRST_PLACEMENT->asset = 2);
  BAD(FIRST_PLACEMENT->asset = ASSETS);
  BAD(FIRST_PLACEMENT->translation[1] = 4097);
  BAD(FIRST_PLACEMENT->translation[2] = (float)NAN);
  BAD(memcpy(FIRST_PLACEMENT, FIRST_PLACEMENT + TEST_PLACEMENTS - 1, sizeof(pack_placement))); /* out of order */
  BAD(TIME[1].first_placement = 1);
  BAD(TIME[1].placement_count -= 1);
  BAD(TIME[2].placement_count += 1);
  BAD(TIME[2].placement_count = UINT32_MAX);
  BAD(TIME[1].bounds_min[0] = TIME[1].bounds_max[0] + 1);
  BAD(TIME[1].bounds_min[1] = (float)NAN);
  BAD(TIME[1].bounds_max[2] = 1e9f);
  BAD(TIME[1].bounds_max[2] = TIME[1].bounds_min[2] + 3);
  BAD(TIME[0].bounds_max[0] = 1);
  BAD(RECORD(float, PACK_UVS)[0] = 2);
  BAD(RECORD(float, PACK_UVS)[1] = (float)NAN);
  BAD(RECORD(float, PACK_UVS)[3] = 1e6f);
  BAD(RECORD(uint32_t, PACK_CELLS)[1] = 2);
  BAD((RECORD(uint32_t, PACK_CELLS)[2] = 5, RECORD(pack_asset, PACK_ASSETS)[4].cell = 1,
       RECORD(pack_asset, PACK_ASSETS)[4].seed = 1));
  BAD(RECORD(pack_asset, PACK_ASSETS)[1].seed = 2);
  BAD(RECORD(pack_asset, PACK_ASSETS)[1].cell = 1);
}

/* The surface of the first vertex of the coarsest level of the cliff at its first time. */
static uint8_t* surface_in(uint8_t* bytes) {
  const pack_blob* blob = RECORD(pack_blob, PACK_BLOB_INDEX) + 1;
  uint8_t* plain = bytes + section_of(bytes, PACK_BLOBS)->offset + blob->offset * (size_t)PACK_BLOB_UNIT;
  return plain + 8 + (size_t)blob->vertices * (3u * plain[6] + 1);
}

static void surfaces_that_cannot_be_are_corrupt(void** state) {
  (void)state;
  BAD(surface_in(bytes)[0] = 3);
  BAD(surface_in(bytes)[2] = 0);
  BAD(RECORD(pack_blob, PACK_BLOB_INDEX)[1].size -= 4);
}

static void a_blob_of_a_model_is_none_of_a_cliff(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(NULL, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  scree_lod level;
  assert_int_equal(scree_pack_get_lod(pack, 0, 0, &level), SCREE_OK);
  uint8_t* cliff_bytes = test_model_pack_make(&several, &size);
  const size_t place = (size_t)section_of(cliff_bytes, PACK_BLOBS)->offset;
  pack_blob* blob = (pack_blob*)data_of(cliff_bytes, PACK_BLOB_INDEX);
  assert_true(blob->size >= level.blob_size);
  memcpy(cliff_bytes + place + blob->offset * (size_t)PACK_BLOB_UNIT, level.blob, level.blob_size);
  blob->size = (uint32_t)level.blob_size;
  blob->vertices = level.vertices;
  ((pack_lod*)data_of(cliff_bytes, PACK_LODS))->triangles = level.triangles;
  test_pack_reseal(cliff_bytes);
  scree_pack* cliff = open_or_fail(cliff_bytes, size);
  static scree_vertex vertices[4096];
  static uint32_t indices[3 * 8192];
  static scree_uv uvs[4096];
  assert_int_equal(scree_draco_decode_u32(pack, 0, 0, vertices, 4096, indices, 3 * 8192), SCREE_OK);
  assert_int_equal(scree_draco_decode_u32(cliff, 0, 0, vertices, 4096, indices, 3 * 8192), SCREE_ERROR_CORRUPT);
  assert_int_equal(scree_draco_decode_uvs(cliff, 0, 0, uvs, NULL, 4096), SCREE_ERROR_CORRUPT);
  scree_pack_close(cliff);
  scree_pack_close(pack);
  free(cliff_bytes);
  free(bytes);
}

#define UNWRITABLE(place, value, expected)                                         \
  do {                                                                             \
    rock_set* set = test_model_set_make(&several);                                 \
    uint32_t* first = (uint32_t*)set->cell_first;                                  \
    cliff_record* cliff = (cliff_record*)set->cliff;                               \
    scree_block_placement* placements = (scree_block_placement*)cliff->placements; \
    uint32_t* placement_first = (uint32_t*)cliff->placement_first;                 \
    const __typeof__(place) before = (place);                                      \
    (void)first, (void)placements, (void)placement_first;                          \
    (place) = (value);                                                             \
    uint8_t* bytes;                                                                \
    size_t size;                                                                   \
    assert_int_equal(pack_write(set, NULL, &bytes, &size), (expected));            \
    assert_null(bytes);                                                            \
    (place) = before;                                                              \
    test_model_set_free(set);                                                      \
  } while (0)

static void sets_that_break_a_rule_are_not_written(void** state) {
  (void)state;
  UNWRITABLE(cliff->time_count, 2, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(cliff->uvs.min[0], 5, SCREE_ERROR_RANGE);
  UNWRITABLE(cliff->uvs.max[1], (float)NAN, SCREE_ERROR_RANGE);
  UNWRITABLE(placement_first[0], 1, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(placement_first[1], 50, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(placements[4].asset, 2, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(placements[4].asset, ASSETS, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(placements[4].translation[0], -5000, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(set->models, NULL, SCREE_ERROR_RANGE);
}

static void a_mesh_without_uvs_is_not_written_into_a_cliff(void** state) {
  (void)state;
  rock_set* set = test_model_set_make(&several);
  rock_set* models = test_model_set_make(&(test_models_desc){.variants = 1, .ages = 1});
  rock_lod* level = &((rock_record*)set->rocks)[4].lods[1];
  const rock_lod kept = *level;
  *level = models->rocks[0].lods[1];
  uint8_t* bytes;
  size_t size;
  assert_int_equal(pack_write(set, NULL, &bytes, &size), SCREE_ERROR_INVALID_ARGUMENT);
  *level = kept;
  test_model_set_free(models);
  test_model_set_free(set);
  float uvs[4][2] = {{0}};
  int16_t positions[4][3] = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
  uint8_t occlusion[4] = {0};
  uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  const lattice_mesh mesh = {
      .positions = positions, .occlusion = occlusion, .indices = indices, .uvs = uvs, .vertex_count = 4, .triangle_count = 4};
  rock_lod out;
  assert_int_equal(plain_encode(&mesh, NULL, &out), SCREE_ERROR_INVALID_ARGUMENT); /* UVs need a surface */
  assert_int_equal(draco_encode(&mesh, NULL, &out), SCREE_ERROR_INVALID_ARGUMENT);
}

static void writing_survives_every_failing_allocation(void** state) {
  (void)state;
  rock_set* set = test_model_set_make(&several);
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  for (int32_t n = 0; result != SCREE_OK; ++n) {
    assert_in_range(n, 0, 20);
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    uint8_t* bytes;
    size_t size;
    result = pack_write(set, &allocator, &bytes, &size);
    if (result == SCREE_OK) allocator.release(allocator.user, bytes, size);
    assert_true(memory.live == 0 && (result == SCREE_ERROR_OUT_OF_MEMORY) == memory.failed);
  }
  test_model_set_free(set);
}

static void encoding_with_uvs_survives_every_failing_allocation(void** state) {
  (void)state;
  int16_t positions[4][3] = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
  uint8_t occlusion[4] = {0}, surface[4][4] = {{0, 0, 128, 1}, {0, 0, 128, 1}, {2, 0, 128, 2}, {2, 0, 128, 3}};
  float uvs[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  const lattice_mesh mesh = {.positions = positions,
                             .occlusion = occlusion,
                             .indices = indices,
                             .surface = surface,
                             .uvs = uvs,
                             .uv_bounds = {{0, 0}, {1, 1}},
                             .vertex_count = 4,
                             .triangle_count = 4};
  for (int plain = 0; plain < 2; ++plain) {
    scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
    for (int32_t n = 0; result != SCREE_OK; ++n) {
      assert_in_range(n, 0, 10);
      failing_allocator memory = {.fail_at = n};
      const scree_allocator allocator = failing_allocator_of(&memory);
      rock_lod out = {.blob = NULL};
      result = (plain ? plain_encode : draco_encode)(&mesh, &allocator, &out);
      if (result == SCREE_OK) allocator.release(allocator.user, out.blob, out.blob_size);
      assert_true(memory.live == 0 && (result == SCREE_ERROR_OUT_OF_MEMORY) == memory.failed);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_written_is_what_is_read),
      cmocka_unit_test(near_placements_are_near_in_the_file),
      cmocka_unit_test(bounds_of_a_time_hold_all_its_blocks),
      cmocka_unit_test(uvs_and_groups_come_back_from_both_codecs),
      cmocka_unit_test(vertices_share_their_normal_by_place_and_group),
      cmocka_unit_test(coarse_normals_are_shared_across_batches),
      cmocka_unit_test(uvs_go_to_the_nearest_value_of_the_range),
      cmocka_unit_test(digest_of_a_cliffs_mesh_is_what_the_format_says_and_sees_uvs_and_groups),
      cmocka_unit_test(what_needs_another_kind_refuses_a_cliff),
      cmocka_unit_test(what_needs_a_cliff_refuses_another_kind),
      cmocka_unit_test(a_cliff_from_which_nothing_fell_is_a_pack),
      cmocka_unit_test(every_flipped_byte_is_found_by_open_or_verify),
      cmocka_unit_test(every_truncation_is_rejected),
      cmocka_unit_test(changed_bytes_with_digests_to_match_never_crash_a_reader),
      cmocka_unit_test(numbers_that_cannot_be_are_corrupt),
      cmocka_unit_test(surfaces_that_cannot_be_are_corrupt),
      cmocka_unit_test(a_blob_of_a_model_is_none_of_a_cliff),
      cmocka_unit_test(sets_that_break_a_rule_are_not_written),
      cmocka_unit_test(a_mesh_without_uvs_is_not_written_into_a_cliff),
      cmocka_unit_test(writing_survives_every_failing_allocation),
      cmocka_unit_test(encoding_with_uvs_survives_every_failing_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
