/* The parts of a cliff in a scene. What stands, what fell and the scree at its foot are fields of their own, so that each may have
 * its colours and its place in the order of layers; to whoever moves the cliff to another time they are one thing.
 *
 * The parts of the cliff that a field shows are
 *   - the fields with the same pack, time, origin, turn and scale,
 *   - the mesh shapes, in any support, of the same pack and time that this cliff is the nearest of that pack to. The nearest, for a
 *     mesh may be a little larger than its cliff, to keep stones off it, and a scene may hold one cliff at many places.
 * A pack is known by its name in the file: a pack named once by its name and once by its path counts as two. */
#ifndef CLIFF_PARTS_H
#define CLIFF_PARTS_H

#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cliff_parts {
  uint64_t fields;     /* bit i: field i shows the cliff */
  uint64_t supports;   /* bit i: the support of field i has meshes of it */
  scene_node** meshes; /* owned, malloc; the nodes are the scene's */
  uint32_t mesh_count, mesh_capacity;
} cliff_parts;

/* The parts of the cliff that field `field` shows. Returns false, with *out all zero, when it shows none or memory is short. */
bool cliff_parts_find(const scene_model* scene, uint32_t field, cliff_parts* out);
void cliff_parts_free(cliff_parts* parts); /* all zero is allowed, and what is left */

/* Moves the parts to another time. They stay valid as long as the scene's nodes. */
void cliff_parts_set_time(const cliff_parts* parts, scene_model* scene, uint32_t time);

#ifdef __cplusplus
}
#endif

#endif
