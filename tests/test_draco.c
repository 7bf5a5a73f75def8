/* Draco and the meshes: what is decoded is what was encoded, to the integer, and bad bytes give a result code. */
#include <scree/draco.h>

#include "allocator.h"
#include "draco_decode.h"
#include "draco_encode.h"
#include "failing_allocator.h"
#include "lattice.h"
#include "make_pack.h"
#include "mesh_digest.h"
#include "mesh_normals.h"
#include "occlusion.h"
#include "synthetic_rock.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct decoded_mesh {
  scree_vertex* vertices;
  uint32_t* indices;
  uint32_t vertex_count, triangle_count;
} decoded_mesh;

static void* checked(void* memory) {
  assert_non_null(memory);
  return memory;
}

static decoded_mesh decode_or_fail(const rock_lod* level) {
  decoded_mesh mesh = {checked(malloc((level->vertex_count + 1) * sizeof(scree_vertex))),
                       checked(malloc(3 * ((size_t)level->triangle_count + 1) * sizeof(uint32_t))), level->vertex_count,
                       level->triangle_count};
  /* An exact-size copy, so that a sanitizer sees a read past its end. */
  uint8_t* blob = checked(malloc(level->blob_size + 1));
  memcpy(blob + 1, level->blob, level->blob_size);
  assert_int_equal(scree_rt_draco_decode_blob(blob + 1, level->blob_size, level->vertex_count, level->triangle_count, false,
                                              mesh.vertices, mesh.indices, 4),
                   SCREE_OK);
  free(blob);
  return mesh;
}

static void free_mesh(decoded_mesh* mesh) {
  free(mesh->vertices);
  free(mesh->indices);
}

static uint64_t digest_of(const decoded_mesh* mesh) {
  return scree_mesh_digest(mesh->vertices, mesh->vertex_count, mesh->indices, mesh->triangle_count);
}

static void release_blob(rock_lod* level) {
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  scree_rt_release(&allocator, level->blob, level->blob_size, 1);
}

/* Encodes, decodes and compares; with both kinds of connectivity, of which the baker uses one. */
static void expect_round_trip(const lattice_mesh* mesh) {
  for (int connectivity = 0; connectivity <= 2; connectivity += 2) {
    draco_encode_options options = draco_encode_defaults();
    options.connectivity = connectivity;
    rock_lod level;
    assert_int_equal(draco_encode_with(&options, mesh, NULL, &level), SCREE_OK);
    assert_int_equal(level.triangle_count, mesh->triangle_count);
    decoded_mesh decoded = decode_or_fail(&level);
    assert_true(digest_of(&decoded) == level.digest);
    free_mesh(&decoded);
    release_blob(&level);
  }
}

static void rocks_decode_to_what_was_encoded(void** state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 30; ++seed)
    for (uint32_t lod = 1; lod <= 4; ++lod) {
      lattice_mesh mesh;
      synthetic_rock_make(seed, seed % 2 ? 10 : 7, seed % 3 ? 4 : 64, lod, &mesh);
      expect_round_trip(&mesh);
      synthetic_rock_free(&mesh);
    }
}

/* The faces of random voxels: components, handles, cavities, and edges and vertices where parts only touch. With `holes`, some
 * triangles are left out, so that the surface has borders. */
static void random_voxel_mesh(uint64_t seed, uint32_t size, bool holes, lattice_mesh* out) {
  const uint32_t side = size + 2, corners = side + 1;
  uint8_t* solid = checked(calloc((size_t)side * side * side, 1));
  uint64_t random = seed;
  const uint64_t share = 20 + seed % 60;
  for (uint32_t z = 1; z <= size; ++z)
    for (uint32_t y = 1; y <= size; ++y)
      for (uint32_t x = 1; x <= size; ++x) solid[(z * side + y) * side + x] = (random = hash_mix(random + 1)) % 100 < share;
  const uint32_t all = corners * corners * corners;
  uint32_t* vertex_of = checked(malloc(all * sizeof *vertex_of));
  memset(vertex_of, 0xff, all * sizeof *vertex_of);
  *out = (lattice_mesh){.positions = checked(malloc(all * sizeof *out->positions)),
                        .occlusion = checked(malloc(all)),
                        .indices = checked(malloc((size_t)side * side * side * 36 * sizeof *out->indices))};
  for (uint32_t cell = 0; cell < side * side * side; ++cell) {
    if (!solid[cell]) continue;
    const uint32_t at[3] = {cell % side, cell / side % side, cell / side / side};
    const uint32_t strides[3] = {1, side, side * side};
    for (uint32_t axis = 0; axis < 3; ++axis)
      for (uint32_t high = 0; high < 2; ++high) {
        if (solid[high ? cell + strides[axis] : cell - strides[axis]]) continue;
        uint32_t quad[4];
        for (uint32_t k = 0; k < 4; ++k) {
          uint32_t p[3] = {at[0], at[1], at[2]};
          p[axis] += high;
          p[(axis + 1) % 3] += k == 1 || k == 2;
          p[(axis + 2) % 3] += k == 2 || k == 3;
          uint32_t* vertex = &vertex_of[(p[2] * corners + p[1]) * corners + p[0]];
          if (*vertex == UINT32_MAX) {
            *vertex = out->vertex_count;
            for (int a = 0; a < 3; ++a)
              out->positions[*vertex][a] = (int16_t)(5 * (int)p[a] + (int)((random = hash_mix(random + 1)) % 3));
            out->occlusion[out->vertex_count++] = (uint8_t)(random >> 8);
          }
          quad[high ? k : 3 - k] = *vertex;
        }
        const uint32_t triangles[2][3] = {{quad[0], quad[1], quad[2]}, {quad[0], quad[2], quad[3]}};
        for (int t = 0; t < 2; ++t) {
          if (holes && (random = hash_mix(random + 1)) % 5 == 0) continue;
          memcpy(out->indices + 3 * (size_t)out->triangle_count++, triangles[t], sizeof triangles[t]);
        }
      }
  }
  free(vertex_of);
  free(solid);
}

static void any_surface_decodes_to_what_was_encoded(void** state) {
  (void)state;
  uint32_t tried = 0;
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    lattice_mesh mesh;
    random_voxel_mesh(seed, 1 + (uint32_t)(seed % 7), seed % 3 == 0, &mesh);
    if (mesh.triangle_count > 0) {
      expect_round_trip(&mesh);
      ++tried;
    }
    synthetic_rock_free(&mesh);
  }
  assert_true(tried > 200);
}

static int16_t tetrahedron_positions[4][3] = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
static uint8_t tetrahedron_occlusion[4] = {0, 85, 170, 255};
static uint32_t tetrahedron_indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
static const lattice_mesh tetrahedron = {
    .positions = tetrahedron_positions,
    .occlusion = tetrahedron_occlusion,
    .indices = tetrahedron_indices,
    .vertex_count = 4,
    .triangle_count = 4,
};

static void the_smallest_meshes_decode(void** state) {
  (void)state;
  lattice_mesh triangle = tetrahedron;
  for (triangle.triangle_count = 1; triangle.triangle_count <= 4; ++triangle.triangle_count) {
    rock_lod level;
    assert_int_equal(draco_encode(&triangle, NULL, &level), SCREE_OK);
    decoded_mesh mesh = decode_or_fail(&level);
    assert_true(digest_of(&mesh) == level.digest);
    free_mesh(&mesh);
    release_blob(&level);
  }
}

static void a_level_without_triangles_is_empty(void** state) {
  (void)state;
  const lattice_mesh empty = {0};
  rock_lod level;
  assert_int_equal(draco_encode(&empty, NULL, &level), SCREE_OK);
  assert_null(level.blob);
  assert_int_equal(level.blob_size + level.vertex_count + level.triangle_count, 0);
  assert_true(level.digest == scree_mesh_digest(NULL, 0, NULL, 0));
  assert_int_equal(scree_rt_draco_decode_blob(NULL, 0, 0, 0, false, NULL, NULL, 2), SCREE_OK);
  assert_int_equal(scree_rt_draco_decode_blob(NULL, 0, 1, 0, false, NULL, NULL, 2), SCREE_ERROR_CORRUPT);
}

static void triangles_that_draco_would_drop_are_refused(void** state) {
  (void)state;
  uint32_t indices[12];
  lattice_mesh mesh = tetrahedron;
  mesh.indices = indices;
  rock_lod level;
  memcpy(indices, tetrahedron_indices, sizeof indices);
  indices[4] = indices[5];
  assert_int_equal(draco_encode(&mesh, NULL, &level), SCREE_ERROR_INVALID_ARGUMENT);
  memcpy(indices, tetrahedron_indices, sizeof indices);
  indices[11] = 4;
  assert_int_equal(draco_encode(&mesh, NULL, &level), SCREE_ERROR_INVALID_ARGUMENT);
  assert_null(level.blob);
}

static void mesh_digest_is_what_the_format_says(void** state) {
  (void)state;
  /* The example of docs/pack_format.md, which tests/pack_reader.py computes from the text. */
  assert_true(scree_rt_mesh_digest(tetrahedron_positions, 6, tetrahedron_occlusion, 1, tetrahedron_indices, 4) ==
              UINT64_C(0x87865a563ad6a90a));
}

static void mesh_digest_ignores_order_and_sees_every_change(void** state) {
  (void)state;
  const uint64_t expected = scree_rt_mesh_digest(tetrahedron_positions, 6, tetrahedron_occlusion, 1, tetrahedron_indices, 4);
  /* Other triangle order, other first corners, vertices renumbered by (3, 2, 1, 0) and one of them twice. */
  const int16_t positions[5][3] = {{0, 0, 10}, {0, 10, 0}, {10, 0, 0}, {0, 0, 0}, {0, 0, 10}};
  const uint8_t occlusion[5] = {255, 170, 85, 0, 255};
  const uint32_t indices[12] = {0, 2, 1, 1, 3, 4, 2, 0, 3, 1, 2, 3};
  assert_true(scree_rt_mesh_digest(positions, 6, occlusion, 1, indices, 4) == expected);

  for (int change = 0; change < 12 + 4; ++change) {
    int16_t moved[4][3];
    uint8_t darker[4];
    memcpy(moved, tetrahedron_positions, sizeof moved);
    memcpy(darker, tetrahedron_occlusion, sizeof darker);
    if (change < 12) {
      moved[change / 3][change % 3] ^= 1;
    } else {
      darker[change - 12] ^= 1;
    }
    assert_true(scree_rt_mesh_digest(moved, 6, darker, 1, tetrahedron_indices, 4) != expected);
  }
  uint32_t flipped[12];
  memcpy(flipped, tetrahedron_indices, sizeof flipped);
  flipped[0] = tetrahedron_indices[1];
  flipped[1] = tetrahedron_indices[0];
  assert_true(scree_rt_mesh_digest(tetrahedron_positions, 6, tetrahedron_occlusion, 1, flipped, 4) != expected);
  assert_true(scree_rt_mesh_digest(tetrahedron_positions, 6, tetrahedron_occlusion, 1, tetrahedron_indices, 3) != expected);
  assert_true(scree_mesh_digest(NULL, 0, tetrahedron_indices, 4) == 0);
}

static void rebuilt_normals_are_area_weighted_and_unit(void** state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    /* Lattices on which sums fit 32 bits, and one on which they do not. */
    const uint32_t steps = seed == 6 ? 1024 : seed % 2 ? 4 : 32;
    lattice_mesh source;
    synthetic_rock_make(seed, 10, steps, 1, &source);
    rock_lod level;
    assert_int_equal(draco_encode(&source, NULL, &level), SCREE_OK);
    decoded_mesh mesh = decode_or_fail(&level);
    double(*expected)[3] = checked(calloc(mesh.vertex_count, sizeof *expected));
    for (uint32_t t = 0; t < mesh.triangle_count; ++t) {
      const uint32_t* corner = mesh.indices + 3 * (size_t)t;
      double u[3], v[3];
      for (int k = 0; k < 3; ++k) {
        u[k] = mesh.vertices[corner[1]].position[k] - mesh.vertices[corner[0]].position[k];
        v[k] = mesh.vertices[corner[2]].position[k] - mesh.vertices[corner[0]].position[k];
      }
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) expected[corner[i]][k] += u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
    double outwards = 0;
    for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
      const double* e = expected[i];
      const double length = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
      for (int k = 0; k < 3; ++k) {
        const double component = length > 0 ? e[k] / length : k == 1;
        assert_true(fabs(mesh.vertices[i].normal[k] - component * 32767) <= 0.54);
        outwards += mesh.vertices[i].normal[k] * (double)mesh.vertices[i].position[k];
      }
      assert_int_equal(mesh.vertices[i].durability | mesh.vertices[i].curvature, 0);
      assert_int_equal(mesh.vertices[i].material, 0);
    }
    assert_true(outwards > 0); /* triangles are still counter-clockwise from outside */
    free(expected);
    free_mesh(&mesh);
    release_blob(&level);
    synthetic_rock_free(&source);
  }
}

static void a_vertex_without_area_gets_a_normal_all_the_same(void** state) {
  (void)state;
  scree_vertex vertices[3] = {{.position = {1, 1, 1}}, {.position = {2, 2, 2}}, {.position = {3, 3, 3}}};
  const uint32_t indices[3] = {0, 1, 2};
  int64_t scratch[9];
  scree_rt_mesh_normals(vertices, 3, indices, 1, scratch);
  for (int i = 0; i < 3; ++i) {
    const int16_t up[3] = {0, 32767, 0};
    assert_memory_equal(vertices[i].normal, up, sizeof up);
  }
}

static void occlusion_survives_in_levels(void** state) {
  (void)state;
  assert_int_equal(occlusion_level(0), 0);
  assert_int_equal(occlusion_level(255), OCCLUSION_MAX);
  assert_int_equal(occlusion_value(0), 0);
  assert_int_equal(occlusion_value(OCCLUSION_MAX), 255);
  assert_int_equal(occlusion_value(-1), 0);
  assert_int_equal(occlusion_value(1000), 255);
  for (int value = 0; value < 256; ++value) {
    const int kept = occlusion_value(occlusion_level((uint8_t)value));
    assert_true(abs(kept - value) <= 255 / (2 * (int)OCCLUSION_MAX) + 1);
    assert_int_equal(occlusion_value(occlusion_level((uint8_t)kept)), kept);
  }
}

static void packs_decode_into_both_widths_of_index(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(NULL, &size);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_OK);
  for (uint32_t asset = 0; asset < 2; ++asset)
    for (uint32_t lod = 0; lod < 2; ++lod) {
      scree_lod level;
      assert_int_equal(scree_pack_get_lod(pack, asset, lod, &level), SCREE_OK);
      const size_t index_count = 3 * (size_t)level.triangles;
      scree_vertex* vertices = checked(malloc(2 * level.vertices * sizeof *vertices));
      uint32_t* wide = checked(malloc(index_count * sizeof *wide));
      uint16_t* narrow = checked(malloc(index_count * sizeof *narrow));
      assert_int_equal(scree_draco_decode_u32(pack, asset, lod, vertices, level.vertices, wide, index_count), SCREE_OK);
      assert_int_equal(scree_draco_decode_u16(pack, asset, lod, vertices + level.vertices, level.vertices, narrow, index_count),
                       SCREE_OK);
      assert_memory_equal(vertices, vertices + level.vertices, level.vertices * sizeof *vertices);
      for (size_t i = 0; i < index_count; ++i) assert_int_equal(wide[i], narrow[i]);
      assert_true(scree_mesh_digest(vertices, level.vertices, wide, level.triangles) == level.digest);

      assert_int_equal(scree_draco_decode_u32(pack, asset, lod, vertices, level.vertices - 1, wide, index_count),
                       SCREE_ERROR_CAPACITY);
      assert_int_equal(scree_draco_decode_u16(pack, asset, lod, vertices, level.vertices, narrow, index_count - 1),
                       SCREE_ERROR_CAPACITY);
      assert_int_equal(scree_draco_decode_u16(pack, asset, lod, NULL, level.vertices, narrow, index_count),
                       SCREE_ERROR_INVALID_ARGUMENT);
      free(vertices);
      free(wide);
      free(narrow);
    }
  assert_int_equal(scree_draco_decode_u16(pack, 2, 0, NULL, 0, NULL, 0), SCREE_ERROR_INVALID_ARGUMENT);
  scree_pack_close(pack);
  free(bytes);
}

static void every_truncated_blob_is_rejected(void** state) {
  (void)state;
  for (int connectivity = 0; connectivity <= 2; connectivity += 2) {
    lattice_mesh mesh;
    synthetic_rock_make(5, 6, 4, 1, &mesh);
    draco_encode_options options = draco_encode_defaults();
    options.connectivity = connectivity;
    rock_lod level;
    assert_int_equal(draco_encode_with(&options, &mesh, NULL, &level), SCREE_OK);
    scree_vertex* vertices = checked(malloc(level.vertex_count * sizeof *vertices));
    uint16_t* indices = checked(malloc(3 * (size_t)level.triangle_count * sizeof *indices));
    for (uint32_t length = 0; length < level.blob_size; ++length) {
      uint8_t* cut = checked(malloc(length > 0 ? length : 1));
      memcpy(cut, level.blob, length);
      assert_int_equal(
          scree_rt_draco_decode_blob(cut, length, level.vertex_count, level.triangle_count, false, vertices, indices, 2),
          SCREE_ERROR_CORRUPT);
      free(cut);
    }
    free(vertices);
    free(indices);
    release_blob(&level);
    synthetic_rock_free(&mesh);
  }
}

/* Changes every byte of blobs in several ways. The decoder must come back; when it is content, triangles must be in range. */
static void changed_blobs_never_crash_the_decoder(void** state) {
  (void)state;
  uint64_t random = 3;
  uint32_t refused = 0, accepted = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    lattice_mesh mesh;
    if (seed % 2) {
      random_voxel_mesh(seed, 4, seed % 4 == 1, &mesh);
    } else {
      synthetic_rock_make(seed, 6, 4, 1, &mesh);
    }
    draco_encode_options options = draco_encode_defaults();
    options.connectivity = seed % 3 ? 2 : 0;
    rock_lod level;
    assert_int_equal(draco_encode_with(&options, &mesh, NULL, &level), SCREE_OK);
    const size_t index_count = 3 * (size_t)level.triangle_count;
    scree_vertex* vertices = checked(malloc(level.vertex_count * sizeof *vertices));
    uint32_t* indices = checked(malloc(index_count * sizeof *indices));
    uint8_t* blob = checked(malloc(level.blob_size));
    for (uint32_t i = 0; i < level.blob_size; ++i)
      for (int turn = 0; turn < 6; ++turn) {
        memcpy(blob, level.blob, level.blob_size);
        random = hash_mix(random + 1);
        blob[i] = turn == 0 ? 0 : turn == 1 ? 255 : (uint8_t)(blob[i] ^ 1 << random % 8);
        if (turn > 3) blob[(random >> 8) % level.blob_size] = (uint8_t)(random >> 40);
        const scree_result result = scree_rt_draco_decode_blob(blob, level.blob_size, level.vertex_count, level.triangle_count,
                                                               false, vertices, indices, 4);
        if (result == SCREE_OK) {
          for (size_t k = 0; k < index_count; ++k) assert_true(indices[k] < level.vertex_count);
          ++accepted;
        } else {
          assert_int_equal(result, SCREE_ERROR_CORRUPT);
          ++refused;
        }
      }
    free(blob);
    free(vertices);
    free(indices);
    release_blob(&level);
    synthetic_rock_free(&mesh);
  }
  assert_true(refused > 1000 && accepted > 100);
}

static void counts_that_do_not_match_the_record_are_refused(void** state) {
  (void)state;
  rock_lod level;
  assert_int_equal(draco_encode(&tetrahedron, NULL, &level), SCREE_OK);
  scree_vertex vertices[16];
  uint32_t indices[48];
  for (uint32_t v = 0; v <= 8; ++v)
    for (uint32_t t = 0; t <= 8; ++t) {
      const scree_result expected = v == 4 && t == 4 ? SCREE_OK : v == 0 && t == 0 ? SCREE_OK : SCREE_ERROR_CORRUPT;
      assert_int_equal(scree_rt_draco_decode_blob(level.blob, level.blob_size, v, t, false, vertices, indices, 4), expected);
    }
  release_blob(&level);
}

static void blobs_that_claim_more_than_the_record_are_refused_before_memory_is_taken(void** state) {
  (void)state;
  /* Behind eleven bytes of head and the kind of edgebreaker come the numbers of vertices, of triangles, of attributes with seams
   * and of symbols. These are 2^15, 2^28, 0 and 2^28, which fit together, and for which libdraco would take gigabytes. */
  enum { HEAD = 12, KEPT = HEAD + 4 };
  static const uint8_t many[] = {0x80, 0x80, 0x02, 0x80, 0x80, 0x80, 0x80, 0x01, 0, 0x80, 0x80, 0x80, 0x80, 0x01};
  rock_lod level;
  assert_int_equal(draco_encode(&tetrahedron, NULL, &level), SCREE_OK);
  assert_int_equal(level.blob[HEAD], 4);
  assert_int_equal(level.blob[HEAD + 1], 4);
  uint8_t* blob = checked(malloc(level.blob_size + sizeof many));
  memcpy(blob, level.blob, HEAD);
  memcpy(blob + HEAD, many, sizeof many);
  memcpy(blob + HEAD + sizeof many, level.blob + KEPT, level.blob_size - KEPT);
  scree_vertex vertices[4];
  uint32_t indices[12];
  assert_int_equal(scree_rt_draco_decode_blob(blob, level.blob_size + sizeof many - 4, 4, 4, false, vertices, indices, 4),
                   SCREE_ERROR_CORRUPT);
  free(blob);
  release_blob(&level);
}

/* An allocator that fails from the n-th call on, and counts what is alive. */
static void every_failed_allocation_of_the_encoder_is_reported(void** state) {
  (void)state;
  for (int32_t n = 0;; ++n) {
    assert_true(n < 10);
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    scree_vertex vertices[4];
    uint16_t indices[12];
    rock_lod level;
    scree_result result = draco_encode(&tetrahedron, &allocator, &level);
    if (result == SCREE_OK) {
      result = scree_rt_draco_decode_blob(level.blob, level.blob_size, 4, 4, false, vertices, indices, 2);
      scree_rt_release(&allocator, level.blob, level.blob_size, 1);
    }
    assert_int_equal(memory.live, 0);
    if (result == SCREE_OK) break;
    assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rocks_decode_to_what_was_encoded),
      cmocka_unit_test(any_surface_decodes_to_what_was_encoded),
      cmocka_unit_test(the_smallest_meshes_decode),
      cmocka_unit_test(a_level_without_triangles_is_empty),
      cmocka_unit_test(triangles_that_draco_would_drop_are_refused),
      cmocka_unit_test(mesh_digest_is_what_the_format_says),
      cmocka_unit_test(mesh_digest_ignores_order_and_sees_every_change),
      cmocka_unit_test(rebuilt_normals_are_area_weighted_and_unit),
      cmocka_unit_test(a_vertex_without_area_gets_a_normal_all_the_same),
      cmocka_unit_test(occlusion_survives_in_levels),
      cmocka_unit_test(packs_decode_into_both_widths_of_index),
      cmocka_unit_test(every_truncated_blob_is_rejected),
      cmocka_unit_test(changed_blobs_never_crash_the_decoder),
      cmocka_unit_test(counts_that_do_not_match_the_record_are_refused),
      cmocka_unit_test(blobs_that_claim_more_than_the_record_are_refused_before_memory_is_taken),
      cmocka_unit_test(every_failed_allocation_of_the_encoder_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
