/* The meshes of packs that need no decoder, and proxies. */
#include <scree/draco.h>

#include "allocator.h"
#include "draco_decode.h"
#include "draco_encode.h"
#include "lattice.h"
#include "make_pack.h"
#include "pack_bytes.h"
#include "pack_format.h"
#include "plain_encode.h"
#include "plain_mesh.h"
#include "synthetic_rock.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct decoded {
  scree_vertex* vertices;
  uint16_t* indices;
  scree_lod level;
} decoded;

/* Buffers of just the size that the record says, so that a sanitizer sees a write past their ends. */
static decoded make_room(const scree_pack* pack, uint32_t asset) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  decoded out;
  assert_int_equal(scree_pack_get_lod(pack, asset, info.lod_count - 1, &out.level), SCREE_OK);
  out.vertices = malloc(out.level.vertices * sizeof *out.vertices);
  out.indices = malloc((size_t)out.level.triangles * 3 * sizeof *out.indices);
  assert_true(out.vertices != NULL && out.indices != NULL);
  return out;
}

static void give_back(decoded* mesh) {
  free(mesh->vertices);
  free(mesh->indices);
}

static scree_result decode_coarse(const scree_pack* pack, uint32_t asset, decoded* mesh) {
  return scree_pack_coarse_mesh(pack, asset, mesh->vertices, mesh->level.vertices, mesh->indices,
                                (size_t)mesh->level.triangles * 3);
}

static void expect_digest(const decoded* mesh) {
  const size_t count = (size_t)mesh->level.triangles * 3;
  uint32_t* wide = malloc(count * sizeof *wide);
  assert_non_null(wide);
  for (size_t i = 0; i < count; ++i) wide[i] = mesh->indices[i];
  assert_true(scree_mesh_digest(mesh->vertices, mesh->level.vertices, wide, mesh->level.triangles) == mesh->level.digest);
  free(wide);
}

/* Meshes with few vertices and many, near and far from the middle: all four widths of numbers. */
static void coarsest_levels_decode_without_draco_to_what_draco_gives(void** state) {
  (void)state;
  uint32_t widths = 0;
  for (uint32_t round = 0; round < 8; ++round) {
    lattice_mesh mesh;
    synthetic_rock_make(round + 1, round % 4 < 2 ? 6 : 14, round % 2 == 0 ? 4 : 64, 1, &mesh);
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
      mesh.positions[v][round % 3] = (int16_t)(mesh.positions[v][round % 3] + (round < 4 ? 0 : -30000));
      mesh.occlusion[v] = (uint8_t)(mesh.occlusion[v] / 17 * 17); /* what Draco's levels keep */
    }
    rock_lod plain, draco;
    assert_int_equal(plain_encode(&mesh, NULL, &plain), SCREE_OK);
    assert_int_equal(draco_encode(&mesh, NULL, &draco), SCREE_OK);
    assert_true(plain.digest == draco.digest);
    assert_int_equal(plain.triangle_count, draco.triangle_count);
    widths |= 1u << (plain.blob[6] - 1 + 2 * (plain.blob[7] - 1));

    plain_mesh read;
    assert_true(scree_rt_plain_mesh_read(plain.blob, plain.blob_size, plain.vertex_count, plain.triangle_count, false, &read));
    scree_vertex* vertices = malloc((plain.vertex_count + draco.vertex_count) * sizeof *vertices);
    uint32_t* indices = malloc((size_t)plain.triangle_count * 6 * sizeof *indices);
    assert_true(vertices != NULL && indices != NULL);
    scree_vertex* other = vertices + plain.vertex_count;
    scree_rt_plain_mesh_decode(&read, vertices, indices, 4);
    assert_int_equal(scree_rt_draco_decode_blob(draco.blob, draco.blob_size, draco.vertex_count, draco.triangle_count, false, other,
                                                indices + (size_t)plain.triangle_count * 3, 4),
                     SCREE_OK);
    assert_true(scree_mesh_digest(vertices, plain.vertex_count, indices, plain.triangle_count) == plain.digest);
    /* Every vertex of the one is a vertex of the other, normal and all. (Rocks have no pinched vertices.) */
    assert_int_equal(plain.vertex_count, draco.vertex_count);
    uint32_t found = 0;
    for (uint32_t v = 0; v < plain.vertex_count; ++v)
      for (uint32_t d = 0; d < draco.vertex_count; ++d)
        if (memcmp(&vertices[v], &other[d], sizeof *vertices) == 0) {
          ++found;
          break;
        }
    assert_int_equal(found, plain.vertex_count);
    free(vertices);
    free(indices);
    const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
    scree_rt_release(&allocator, plain.blob, plain.blob_size, 1);
    scree_rt_release(&allocator, draco.blob, draco.blob_size, 1);
    synthetic_rock_free(&mesh);
  }
  assert_int_equal(widths, 15);
}

static void coarse_meshes_of_rocks_and_proxies_are_what_was_packed(void** state) {
  (void)state;
  for (uint32_t lods = 1; lods <= 2; ++lods) {
    const test_pack_desc desc = {.lod_count = lods, .proxies = true};
    size_t size;
    uint8_t* bytes = test_pack_make(&desc, &size);
    scree_pack* pack = open_or_fail(bytes, size);
    assert_int_equal(scree_pack_verify(pack), SCREE_OK);
    scree_pack_info info;
    scree_pack_get_info(pack, &info);
    assert_int_equal(info.proxy_count, 256 * 9);
    assert_int_equal(info.proxy_per_cell, 20);
    for (uint32_t asset = 0; asset < info.asset_count + info.proxy_count; asset += asset < 20 ? 1 : 91) {
      decoded mesh = make_room(pack, asset);
      assert_int_equal(decode_coarse(pack, asset, &mesh), SCREE_OK);
      expect_digest(&mesh);
      assert_int_equal(scree_pack_coarse_mesh(pack, asset, mesh.vertices, mesh.level.vertices - 1, mesh.indices,
                                              (size_t)mesh.level.triangles * 3),
                       SCREE_ERROR_CAPACITY);
      assert_int_equal(scree_pack_coarse_mesh(pack, asset, mesh.vertices, mesh.level.vertices, mesh.indices,
                                              (size_t)mesh.level.triangles * 3 - 1),
                       SCREE_ERROR_CAPACITY);
      assert_int_equal(scree_pack_coarse_mesh(pack, asset, NULL, mesh.level.vertices, mesh.indices, SIZE_MAX),
                       SCREE_ERROR_INVALID_ARGUMENT);
      give_back(&mesh);
    }
    assert_int_equal(scree_pack_coarse_mesh(pack, info.asset_count + info.proxy_count, NULL, 0, NULL, 0),
                     SCREE_ERROR_INVALID_ARGUMENT);
    scree_pack_close(pack);
    free(bytes);
  }
}

static void proxies_are_numbered_by_code_and_part_behind_the_rocks(void** state) {
  (void)state;
  const test_pack_desc desc = {.rocks_per_cell = 2, .proxies = true};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  for (uint32_t code = 0; code < 256; ++code)
    for (uint32_t part = 0; part < 9; ++part) assert_int_equal(scree_pack_proxy(pack, code, part), 3 + 9 * code + part);
  assert_int_equal(scree_pack_proxy(pack, 256, 0), UINT32_MAX);
  assert_int_equal(scree_pack_proxy(pack, 0, 9), UINT32_MAX);
  scree_lod level;
  assert_int_equal(scree_pack_get_lod(pack, 3 + 256 * 9 - 1, 0, &level), SCREE_OK);
  assert_int_equal(scree_pack_get_lod(pack, 3 + 256 * 9, 0, &level), SCREE_ERROR_INVALID_ARGUMENT);
  scree_asset asset;
  assert_int_equal(scree_pack_get_asset(pack, 3, &asset), SCREE_ERROR_INVALID_ARGUMENT); /* a proxy is no rock */
  scree_pack_close(pack);

  /* A header that says that there are none, or says so of a pack that has none. */
  header_of(bytes)->proxy_per_cell = 0;
  assert_int_equal(open_resealed(bytes, size), SCREE_ERROR_CORRUPT);
  header_of(bytes)->proxy_per_cell = PACK_MAX_LATTICE_PER_CELL + 1;
  assert_int_equal(open_resealed(bytes, size), SCREE_ERROR_CORRUPT);
  free(bytes);
  bytes = test_pack_make(NULL, &size);
  header_of(bytes)->proxy_per_cell = 20;
  assert_int_equal(open_resealed(bytes, size), SCREE_ERROR_CORRUPT);
  free(bytes);
}

static void plain_meshes_that_cannot_be_are_refused(void** state) {
  (void)state;
  const test_pack_desc desc = {.lod_count = 1};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  decoded mesh = make_room(pack, 0);
  uint8_t* blob = (uint8_t*)data_of(bytes, PACK_BLOBS);
  pack_blob* index = data_of(bytes, PACK_BLOB_INDEX);
  pack_lod* lod = data_of(bytes, PACK_LODS);
  assert_int_equal(decode_coarse(pack, 0, &mesh), SCREE_OK);
  const uint32_t corners = PLAIN_MESH_HEAD + mesh.level.vertices * 4;
  assert_int_equal(blob[6] + blob[7], 2);
  REFUSED(blob[6], 0, decode_coarse(pack, 0, &mesh));
  REFUSED(blob[6], 2, decode_coarse(pack, 0, &mesh));
  REFUSED(blob[6], 255, decode_coarse(pack, 0, &mesh));
  REFUSED(blob[7], 0, decode_coarse(pack, 0, &mesh));
  REFUSED(blob[7], 2, decode_coarse(pack, 0, &mesh));
  REFUSED(blob[1], 0x7f, decode_coarse(pack, 0, &mesh)); /* base 32,5xx: positions leave int16 */
  REFUSED(blob[corners], (uint8_t)mesh.level.vertices, decode_coarse(pack, 0, &mesh));
  REFUSED(index->size, index->size - 1, decode_coarse(pack, 0, &mesh));
  REFUSED(index->size, 7, decode_coarse(pack, 0, &mesh));
  REFUSED(index->vertices, index->vertices - 1, decode_coarse(pack, 0, &mesh));
  REFUSED(lod->triangles, lod->triangles - 1, decode_coarse(pack, 0, &mesh));
  give_back(&mesh);
  scree_pack_close(pack);
  free(bytes);
}

/* A reader that meets any bytes comes back, and what it accepts has triangles of vertices. */
static void changed_plain_meshes_never_crash_a_reader(void** state) {
  (void)state;
  const test_pack_desc desc = {.lod_count = 1};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  decoded mesh = make_room(pack, 0);
  uint8_t* blob = (uint8_t*)data_of(bytes, PACK_BLOBS);
  uint32_t accepted = 0, refused = 0;
  uint64_t random = 5;
  for (size_t i = 0; i < mesh.level.blob_size; ++i)
    for (int turn = 0; turn < 8; ++turn) {
      const uint8_t saved = blob[i];
      blob[i] = turn == 0 ? 0 : turn == 1 ? 255 : (uint8_t)(random = hash_mix(random + 1));
      const scree_result result = decode_coarse(pack, 0, &mesh);
      assert_true(result == SCREE_OK || result == SCREE_ERROR_CORRUPT);
      if (result == SCREE_OK) {
        ++accepted;
        for (size_t k = 0; k < (size_t)mesh.level.triangles * 3; ++k) assert_true(mesh.indices[k] < mesh.level.vertices);
      } else {
        ++refused;
      }
      blob[i] = saved;
    }
  assert_true(accepted > 1000 && refused > 300);
  give_back(&mesh);
  scree_pack_close(pack);
  free(bytes);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(coarsest_levels_decode_without_draco_to_what_draco_gives),
      cmocka_unit_test(coarse_meshes_of_rocks_and_proxies_are_what_was_packed),
      cmocka_unit_test(proxies_are_numbered_by_code_and_part_behind_the_rocks),
      cmocka_unit_test(plain_meshes_that_cannot_be_are_refused),
      cmocka_unit_test(changed_plain_meshes_never_crash_a_reader),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
