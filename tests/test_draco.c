/* Draco and the meshes: what is decoded is what was encoded, to the integer. */
#include <scree/draco.h>

#include "allocator.h"
#include "draco_decode.h"
#include "draco_encode.h"
#include "lattice.h"
#include "make_pack.h"
#include "mesh_digest.h"
#include "occlusion.h"
#include "rock_mesh.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void release_blob(rock_lod* level) {
  const scree_allocator allocator = allocator_or_default(NULL);
  release(&allocator, level->blob, level->blob_size, 1);
}

static void decoded_meshes_are_the_encoded_ones(void** state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 40; ++seed)
    for (uint32_t lod = 1; lod <= 4; ++lod) {
      lattice_mesh mesh;
      rock_mesh_make(seed, seed % 2 ? 10 : 7, seed % 3 ? 4 : 16, lod, &mesh);
      rock_lod level;
      assert_int_equal(draco_encode(&mesh, NULL, &level), SCREE_OK);
      assert_int_equal(level.triangle_count, mesh.triangle_count);
      assert_true(level.vertex_count >= mesh.vertex_count);
      scree_vertex* vertices = malloc(level.vertex_count * sizeof *vertices);
      uint32_t* indices = malloc(3 * (size_t)level.triangle_count * sizeof *indices);
      assert_int_equal(
          draco_decode_blob(level.blob, level.blob_size, level.vertex_count, level.triangle_count, vertices, indices, 4), SCREE_OK);
      assert_true(scree_mesh_digest(vertices, level.vertex_count, indices, level.triangle_count) == level.digest);
      free(vertices);
      free(indices);
      release_blob(&level);
      rock_mesh_free(&mesh);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(decoded_meshes_are_the_encoded_ones),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
