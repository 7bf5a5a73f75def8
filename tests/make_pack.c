#include "make_pack.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "allocator.h"
#include "draco_encode.h"
#include "lattice.h"
#include "pack_format.h"
#include "pack_writer.h"
#include "plain_encode.h"
#include "synthetic_rock.h"

#define TEST_RECIPE "{\"name\": \"test\", \"note\": \"not baked\"}"

static void* checked(void* memory) {
  if (memory == NULL) abort();
  return memory;
}

static test_pack_desc with_defaults(const test_pack_desc* given) {
  test_pack_desc desc = given != NULL ? *given : (test_pack_desc){0};
  if (desc.cells_per_cube == 0) desc.cells_per_cube = 1;
  if (desc.rocks_per_cell == 0) desc.rocks_per_cell = 1;
  if (desc.lod_count == 0) desc.lod_count = 2;
  if (desc.voxels_per_cell == 0) desc.voxels_per_cell = 6;
  if (desc.shapes == 0) desc.shapes = 4;
  return desc;
}

/* The hull is the extreme vertices along the axes and diagonals: not the convex hull, but as many numbers. */
static void fill_hull(const lattice_mesh* mesh, rock_record* rock) {
  static const int directions[14][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},   {0, -1, 0}, {0, 0, 1},   {0, 0, -1},  {1, 1, 1},
                                        {1, 1, -1}, {1, -1, 1}, {1, -1, -1}, {-1, 1, 1}, {-1, 1, -1}, {-1, -1, 1}, {-1, -1, -1}};
  rock->hull = checked(malloc(14 * sizeof *rock->hull));
  rock->hull_count = 14;
  for (int i = 0; i < 14; ++i) {
    int best = INT32_MIN;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
      const int16_t* p = mesh->positions[v];
      const int reach = directions[i][0] * p[0] + directions[i][1] * p[1] + directions[i][2] * p[2];
      if (reach <= best) continue;
      best = reach;
      memcpy(rock->hull[i], p, sizeof rock->hull[i]);
    }
  }
}

static void fill_bounds(const lattice_mesh* mesh, rock_record* rock) {
  for (int axis = 0; axis < 3; ++axis) {
    rock->bounds_min[axis] = INT16_MAX;
    rock->bounds_max[axis] = INT16_MIN;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
      const int16_t p = mesh->positions[v][axis];
      if (p < rock->bounds_min[axis]) rock->bounds_min[axis] = p;
      if (p > rock->bounds_max[axis]) rock->bounds_max[axis] = p;
    }
  }
}

static void fill_contacts(uint64_t seed, rock_record* rock) {
  rock->contact_count = 3 + (uint32_t)(hash_mix(seed) % 8);
  rock->contacts = checked(malloc(rock->contact_count * sizeof *rock->contacts));
  for (uint32_t i = 0; i < rock->contact_count; ++i) {
    const int16_t at = (int16_t)(hash_mix(seed + i) % 41) - 20;
    const uint32_t neighbour = 2 * i;
    rock->contacts[i] = (scree_contact){
        .position = {at, (int16_t)-at, (int16_t)i},
        .cell = {(int8_t)(neighbour % 3 - 1), (int8_t)(neighbour / 3 % 3 - 1), (int8_t)(neighbour / 9 - 1)},
    };
  }
}

static void fill_rock(uint64_t seed, const test_pack_desc* desc, rock_record* rock) {
  for (uint32_t lod = 0; lod < desc->lod_count; ++lod) {
    lattice_mesh mesh;
    synthetic_rock_make(seed, desc->voxels_per_cell, 4, lod + 1, &mesh);
    if (lod == 0) {
      fill_hull(&mesh, rock);
      fill_bounds(&mesh, rock);
    }
    const bool coarsest = lod + 1 == desc->lod_count;
    if ((coarsest ? plain_encode : draco_encode)(&mesh, NULL, &rock->lods[lod]) != SCREE_OK) abort();
    synthetic_rock_free(&mesh);
  }
  fill_contacts(seed, rock);
  for (int axis = 0; axis < 3; ++axis) rock->centroid[axis] = (float)(hash_mix(seed * 3 + (uint64_t)axis) % 101) / 1000.0f;
  rock->burial = 1 + (uint32_t)(seed % SCREE_BURIAL_NEVER);
  rock->volume = 0.5f;
  rock->inner_radius = 0.25f;
  rock->outer_radius = 0.75f + (float)(seed % 16) / 64.0f;
}

rock_set* test_rock_set_make(const test_pack_desc* given) {
  const test_pack_desc desc = with_defaults(given);
  const uint32_t cell_count = scree_rt_lattice_cell_count(desc.cells_per_cube);
  uint32_t* first = checked(malloc((cell_count + 1) * sizeof *first));
  first[0] = 0;
  for (uint32_t cell = 0; cell < cell_count; ++cell) first[cell + 1] = first[cell] + 1 + cell % desc.rocks_per_cell;
  rock_record* rocks = checked(calloc(first[cell_count], sizeof *rocks));
  for (uint32_t cell = 0; cell < cell_count; ++cell)
    for (uint32_t i = first[cell]; i < first[cell + 1]; ++i) {
      /* Shapes repeat, and with them their memory: rock i owns it only when i < shapes. */
      if (i < desc.shapes) {
        fill_rock(i + 1, &desc, &rocks[i]);
      } else {
        rocks[i] = rocks[i % desc.shapes];
      }
      rocks[i].cell = cell;
      rocks[i].seed = i - first[cell];
    }
  proxy_record* proxies = desc.proxies ? checked(calloc(PACK_PROXIES, sizeof *proxies)) : NULL;
  for (uint32_t i = 0; i < PACK_PROXIES && proxies != NULL; ++i)
    memcpy(proxies[i].lods, rocks[i % desc.shapes % first[cell_count]].lods, sizeof proxies[i].lods);
  rock_set* set = checked(malloc(sizeof *set));
  *set = (rock_set){
      .cells_per_cube = desc.cells_per_cube,
      .lattice_per_cell = desc.voxels_per_cell * 4,
      .lod_count = desc.lod_count,
      .cell_count = cell_count,
      .rock_count = first[cell_count],
      .cell_first = first,
      .rocks = rocks,
      .proxies = proxies,
      .proxy_per_cell = desc.proxies ? 20 : 0,
      .recipe = TEST_RECIPE,
  };
  return set;
}

void test_rock_set_free(rock_set* set) {
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  for (uint32_t i = 0; i < set->rock_count; ++i) {
    rock_record* rock = (rock_record*)&set->rocks[i];
    /* A repeated shape has the memory of an earlier rock. */
    bool owner = true;
    for (uint32_t k = 0; k < i && k < 64 && owner; ++k) owner = set->rocks[k].hull != rock->hull;
    if (!owner) continue;
    for (uint32_t lod = 0; lod < set->lod_count; ++lod)
      scree_rt_release(&allocator, rock->lods[lod].blob, rock->lods[lod].blob_size, 1);
    free(rock->contacts);
    free(rock->hull);
  }
  free((void*)set->proxies);
  free((void*)set->rocks);
  free((void*)set->cell_first);
  free(set);
}

uint8_t* test_pack_make(const test_pack_desc* desc, size_t* size) {
  rock_set* set = test_rock_set_make(desc);
  uint8_t* bytes;
  if (pack_write(set, NULL, &bytes, size) != SCREE_OK) abort();
  test_rock_set_free(set);
  return bytes; /* the default allocator's memory is freed with free() */
}

void test_pack_reseal(uint8_t* bytes) {
  pack_header* header = (pack_header*)(void*)bytes;
  pack_section* table = (pack_section*)(void*)(bytes + sizeof *header);
  const pack_section* sections[PACK_SECTION_KINDS] = {0};
  for (uint32_t i = 0; i < header->section_count; ++i) {
    pack_section* section = &table[i];
    if (section->offset + section->size <= header->file_size)
      section->digest = scree_rt_pack_bytes_digest(bytes + section->offset, (size_t)section->size);
    if (section->kind >= 1 && section->kind <= PACK_SECTION_KINDS) sections[section->kind - 1] = section;
  }
  /* A digest of kinds that are not there is never looked at. */
  const pack_section none = {0};
  for (uint32_t i = 0; i < PACK_SECTION_KINDS; ++i)
    if (sections[i] == NULL) sections[i] = &none;
  header->table_digest = scree_rt_pack_bytes_digest(table, header->section_count * sizeof *table);
  header->pack_digest = scree_rt_pack_digest(header, sections);
  header->header_check = scree_rt_pack_header_check(header);
}
