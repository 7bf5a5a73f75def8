/* scree-bench-codec [NAME]: how fast meshes are decoded and encoded, one JSON object a line.
 * scree-bench-codec --choices: the table of docs/codecs.md, as Markdown.
 *
 * Rocks are those of the default recipe at n = 4 (2,266 instead of 17,202, of the same kind), one thread, medians of several runs
 * by the thread's own clock. `reference` of draco.decode is what libdraco alone takes for the same blobs in the same run, before
 * vertices are laid out and normals rebuilt. NAME: only figures whose name starts with it. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <scree/bake.h>
#include <scree/draco.h>

#define BENCH_PROGRAM "scree-bench-codec"
#include "allocator.h"
#include "bench.h"
#include "bench_libdraco.h"
#include "draco_decode.h"
#include "draco_encode.h"
#include "mesh_normals.h"

enum { RUNS = 7, EVERY = 4, FINE_STEPS = 64, MOST_VERTICES = 1 << 18 };

/* --- rocks ------------------------------------------------------------------------------------------------------------------ */

static scree_pack* bake(uint32_t lattice_steps, uint8_t** bytes) {
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.lattice_steps = lattice_steps;
  const scree_bake_desc desc = {.recipe = &recipe};
  size_t size;
  scree_pack* pack;
  if (scree_bake_rocks(&desc, bytes, &size, NULL, NULL) != SCREE_OK) die("the recipe cannot be baked");
  if (scree_pack_open_memory(*bytes, size, NULL, &pack) != SCREE_OK) die("the pack cannot be opened");
  return pack;
}

static uint32_t asset_count(const scree_pack* pack) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  return info.asset_count;
}

static scree_lod level_of(const scree_pack* pack, uint32_t asset, uint32_t lod) {
  scree_lod level;
  if (scree_pack_get_lod(pack, asset, lod, &level) != SCREE_OK || level.vertices > MOST_VERTICES) die("a level cannot be read");
  return level;
}

/* A mesh of the pack on a lattice that is `divisor` times coarser. */
static lattice_mesh mesh_of(const scree_pack* pack, uint32_t asset, uint32_t lod, int divisor) {
  const scree_lod level = level_of(pack, asset, lod);
  lattice_mesh mesh = {.positions = must(malloc((level.vertices + 1) * sizeof *mesh.positions)),
                       .occlusion = must(malloc(level.vertices + 1)),
                       .indices = must(malloc(3 * ((size_t)level.triangles + 1) * sizeof *mesh.indices)),
                       .vertex_count = level.vertices,
                       .triangle_count = level.triangles};
  scree_vertex* vertices = must(malloc((level.vertices + 1) * sizeof *vertices));
  if (scree_draco_decode_u32(pack, asset, lod, vertices, level.vertices, mesh.indices, 3 * (size_t)level.triangles) != SCREE_OK)
    die("a mesh cannot be decoded");
  for (uint32_t i = 0; i < level.vertices; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      mesh.positions[i][axis] = (int16_t)floor((double)vertices[i].position[axis] / divisor + 0.5);
    mesh.occlusion[i] = vertices[i].occlusion;
  }
  free(vertices);
  return mesh;
}

static void free_mesh(lattice_mesh* mesh) {
  free(mesh->positions);
  free(mesh->occlusion);
  free(mesh->indices);
}

/* --- figures ---------------------------------------------------------------------------------------------------------------- */

static bool wanted(const char* prefix, const char* name) {
  return strncmp(name, prefix, strlen(prefix)) == 0;
}

static void figure(const char* prefix, const char* name, double value, const char* unit, double reference) {
  if (!wanted(prefix, name)) return;
  printf("{\"name\": \"%s\", \"value\": %.4g, \"unit\": \"%s\"", name, value, unit);
  if (reference > 0) printf(", \"reference\": %.4g, \"ratio\": %.3f", reference, value / reference);
  printf("}\n");
}

static void bench_decode(const scree_pack* pack, const char* prefix) {
  const uint32_t rocks = asset_count(pack);
  scree_vertex* vertices = must(malloc(MOST_VERTICES * sizeof *vertices));
  uint16_t* indices = must(malloc(6 * (size_t)MOST_VERTICES * sizeof *indices));
  for (uint32_t lod = 0; lod < 2; ++lod) {
    double ours[RUNS], alone[RUNS];
    for (int run = 0; run < RUNS; ++run) {
      double start = seconds();
      for (uint32_t i = 0; i < rocks; ++i)
        if (scree_draco_decode_u16(pack, i, lod, vertices, MOST_VERTICES, indices, 6 * (size_t)MOST_VERTICES) != SCREE_OK)
          die("a mesh cannot be decoded");
      ours[run] = seconds() - start;
      start = seconds();
      for (uint32_t i = 0; i < rocks; ++i) {
        const scree_lod level = level_of(pack, i, lod);
        if (!bench_libdraco_decode(level.blob, level.blob_size)) die("libdraco refuses a mesh");
      }
      alone[run] = seconds() - start;
    }
    figure(prefix, lod == 0 ? "draco.decode" : "draco.decode_lod1", rocks / median(ours, RUNS), "rocks/s",
           rocks / median(alone, RUNS));
  }
  free(vertices);
  free(indices);
}

static void bench_encode(const scree_pack* pack, const char* prefix) {
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  double spent = 0, bytes = 0, triangles = 0;
  uint32_t rocks = 0;
  for (uint32_t i = 0; i < info.asset_count; i += EVERY, ++rocks)
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) {
      lattice_mesh mesh = mesh_of(pack, i, lod, 1);
      rock_lod level;
      const double start = seconds();
      if (draco_encode(&mesh, &allocator, &level) != SCREE_OK) die("a mesh cannot be encoded");
      spent += seconds() - start;
      bytes += level.blob_size;
      triangles += level.triangle_count;
      scree_rt_release(&allocator, level.blob, level.blob_size, 1);
      free_mesh(&mesh);
    }
  figure(prefix, "draco.encode", rocks / spent, "rocks/s, all levels", 0);
  figure(prefix, "draco.bytes", bytes / rocks, "bytes/rock, all levels", 0);
  figure(prefix, "draco.bytes_per_triangle", bytes / triangles, "bytes/triangle, all levels", 0);
}

/* --- choices ---------------------------------------------------------------------------------------------------------------- */

typedef struct sample {
  lattice_mesh* meshes;
  uint32_t count;
} sample;

static sample take_sample(const scree_pack* pack, uint32_t lod, int divisor) {
  sample taken = {must(malloc((asset_count(pack) / EVERY + 1) * sizeof(lattice_mesh))), 0};
  for (uint32_t i = 0; i < asset_count(pack); i += EVERY) taken.meshes[taken.count++] = mesh_of(pack, i, lod, divisor);
  return taken;
}

static void free_sample(sample* taken) {
  for (uint32_t i = 0; i < taken->count; ++i) free_mesh(&taken->meshes[i]);
  free(taken->meshes);
}

/* Rocks that follow one another, as one mesh. */
static lattice_mesh join(const lattice_mesh* meshes, uint32_t count) {
  lattice_mesh all = {0};
  for (uint32_t i = 0; i < count; ++i) {
    all.vertex_count += meshes[i].vertex_count;
    all.triangle_count += meshes[i].triangle_count;
  }
  all.positions = must(malloc(all.vertex_count * sizeof *all.positions));
  all.occlusion = must(malloc(all.vertex_count));
  all.indices = must(malloc(3 * (size_t)all.triangle_count * sizeof *all.indices));
  uint32_t vertex = 0;
  size_t corner = 0;
  for (uint32_t i = 0; i < count; ++i) {
    memcpy(all.positions + vertex, meshes[i].positions, meshes[i].vertex_count * sizeof *all.positions);
    memcpy(all.occlusion + vertex, meshes[i].occlusion, meshes[i].vertex_count);
    for (size_t k = 0; k < 3 * (size_t)meshes[i].triangle_count; ++k) all.indices[corner++] = meshes[i].indices[k] + vertex;
    vertex += meshes[i].vertex_count;
  }
  return all;
}

/* Encodes the sample in groups and prints bytes, encoding and libdraco's decoding time a rock. */
static void row(const char* name, const sample* taken, const draco_encode_options* options, uint32_t group) {
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  double bytes = 0, encoding = 0, decoding[3] = {0, 0, 0};
  uint32_t rocks = 0;
  for (uint32_t i = 0; i + group <= taken->count; i += group, rocks += group) {
    lattice_mesh mesh = join(taken->meshes + i, group);
    rock_lod level;
    const double start = seconds();
    if (draco_encode_with(options, &mesh, &allocator, &level) != SCREE_OK) die("a mesh cannot be encoded");
    encoding += seconds() - start;
    bytes += level.blob_size;
    for (int run = 0; run < 3; ++run) {
      const double begin = seconds();
      if (!bench_libdraco_decode(level.blob, level.blob_size)) die("libdraco refuses a mesh");
      decoding[run] += seconds() - begin;
    }
    scree_rt_release(&allocator, level.blob, level.blob_size, 1);
    free_mesh(&mesh);
  }
  printf("| %s | %.0f | %.0f | %.1f |\n", name, bytes / rocks, 1e6 * encoding / rocks, 1e6 * median(decoding, 3) / rocks);
}

static void head(const char* what) {
  printf("\n| %s | bytes a rock | encode, us | libdraco decodes, us |\n| --- | --- | --- | --- |\n", what);
}

/* Mean angle between the rebuilt normals of a mesh and of the same mesh on the fine lattice, degrees. */
static double normal_error(const lattice_mesh* mesh, const lattice_mesh* fine) {
  const lattice_mesh* both[2] = {mesh, fine};
  scree_vertex* vertices[2];
  for (int k = 0; k < 2; ++k) {
    vertices[k] = must(calloc(mesh->vertex_count + 1, sizeof *vertices[k]));
    void* scratch = must(malloc((mesh->vertex_count + 1) * MESH_NORMALS_SCRATCH));
    for (uint32_t i = 0; i < mesh->vertex_count; ++i)
      memcpy(vertices[k][i].position, both[k]->positions[i], sizeof vertices[k][i].position);
    scree_rt_mesh_normals(vertices[k], mesh->vertex_count, mesh->indices, mesh->triangle_count, scratch);
    free(scratch);
  }
  double sum = 0;
  for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
    double dot = 0;
    for (int axis = 0; axis < 3; ++axis) dot += (double)vertices[0][i].normal[axis] * vertices[1][i].normal[axis];
    sum += acos(fmin(1, dot / (32767.0 * 32767.0))) * 180 / 3.14159265358979;
  }
  free(vertices[0]);
  free(vertices[1]);
  return mesh->vertex_count > 0 ? sum / mesh->vertex_count : 0;
}

static void print_choices(void) {
  uint8_t* bytes;
  scree_pack* pack = bake(FINE_STEPS, &bytes);
  const draco_encode_options defaults = draco_encode_defaults();
  char name[64];

  printf("| lattice steps a voxel | bytes a rock, LOD 0 | LOD 1 | LOD 2 | LOD 3 | normals off by, degrees |\n");
  printf("| --- | --- | --- | --- | --- | --- |\n");
  sample fine = take_sample(pack, 0, 1);
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  for (int steps = 2; steps <= 16; steps *= 2) {
    double sizes[4] = {0}, error = 0;
    for (uint32_t lod = 0; lod < 4; ++lod) {
      sample taken = take_sample(pack, lod, FINE_STEPS / steps);
      for (uint32_t i = 0; i < taken.count; ++i) {
        rock_lod level;
        if (draco_encode(&taken.meshes[i], &allocator, &level) != SCREE_OK) die("a mesh cannot be encoded");
        sizes[lod] += level.blob_size;
        scree_rt_release(&allocator, level.blob, level.blob_size, 1);
        if (lod == 0) error += normal_error(&taken.meshes[i], &fine.meshes[i]);
      }
      sizes[lod] /= taken.count;
      free_sample(&taken);
    }
    printf("| %d | %.0f | %.0f | %.0f | %.0f | %.1f |\n", steps, sizes[0], sizes[1], sizes[2], sizes[3], error / fine.count);
  }
  free_sample(&fine);

  sample rocks = take_sample(pack, 0, FINE_STEPS / 8), coarse = take_sample(pack, 3, FINE_STEPS / 8);
  head("LOD 0, 8 steps: Draco speed");
  for (int speed = 0; speed <= 10; ++speed) {
    draco_encode_options options = defaults;
    options.speed = speed;
    snprintf(name, sizeof name, "%d", speed);
    row(name, &rocks, &options, 1);
  }
  draco_encode_options options = defaults;
  head("how triangles are coded");
  row("edgebreaker, standard", &rocks, &options, 1);
  options.connectivity = 2;
  row("edgebreaker, by valence", &rocks, &options, 1);
  options.sequential = true;
  row("sequential", &rocks, &options, 1);
  head("occlusion");
  for (int bits = 0; bits <= 4; ++bits) { /* the baked rocks keep 4: more cannot be measured on them */
    options = defaults;
    options.occlusion_bits = bits;
    snprintf(name, sizeof name, "%d bits, fourth component", bits);
    row(name, &rocks, &options, 1);
  }
  options = defaults;
  options.occlusion_apart = true;
  row("4 bits, an attribute of its own", &rocks, &options, 1);
  options.separate_surfaces = true;
  row("the same, with seams allowed", &rocks, &options, 1);
  head("normals");
  row("rebuilt after decoding", &rocks, &defaults, 1);
  options = defaults;
  options.keep_normals = true;
  row("kept, 8 bits octahedral", &rocks, &options, 1);
  head("rocks in a blob");
  for (uint32_t group = 1; group <= 64; group *= group == 1 ? 16 : 2) {
    snprintf(name, sizeof name, "%u, LOD 0", group);
    row(name, &rocks, &defaults, group);
    snprintf(name, sizeof name, "%u, LOD 3", group);
    row(name, &coarse, &defaults, group);
  }
  free_sample(&rocks);
  free_sample(&coarse);
  scree_pack_close(pack);
  free(bytes);
}

int main(int argc, char** argv) {
  if (argc > 2) die("usage: scree-bench-codec [NAME | --choices]");
  if (argc > 1 && strcmp(argv[1], "--choices") == 0) {
    print_choices();
    return 0;
  }
  const char* prefix = argc > 1 ? argv[1] : "";
  if (!wanted(prefix, "draco.") && !wanted("draco.", prefix)) return 0;
  uint8_t* bytes;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  scree_pack* pack = bake(recipe.lattice_steps, &bytes);
  bench_decode(pack, prefix);
  bench_encode(pack, prefix);
  scree_pack_close(pack);
  free(bytes);
  return 0;
}
