/* Stability of what stands: groups of shards that hang on links too weak for their weight. The rule's words are at
 * scree_frost_check_stability in scree/frost.h; its formulas are here.
 *
 * Let g be the vector of gravity, 9.81 m/s^2 along the rules' direction, and d(i) the distance of shard i from the supported ones,
 * in unbroken links between shards that are not air. What no such links join to a supported shard has no distance, and the rule
 * says nothing of it (in a simulation it fell: frost_settle); nor of anything where nothing is supported. For a level d > 0 a group
 * is a component, by such links, of the shards at distance >= d; its cut is its links to distance d - 1.
 *
 *   m = density * sum of volumes, G = centre of mass, W = m g
 *   link k of the cut: area a_k, life l_k, centroid x_k, unit normal n_k into the group,
 *                      K_k = integral of (x - x_k)(x - x_k)^T over its polygons
 *   A = sum l_k a_k,  c = sum l_k a_k x_k / A,  r_k = x_k - c
 *   J = sum l_k (a_k (|r_k|^2 E - r_k r_k^T) + tr(K_k) E - K_k), and 1e-9 of its trace along its diagonal, so that a cut that is
 *       all but a line bears all but no moment about that line
 *   moment M = (G - c) x W,  J t = M
 *   what a place x of the cut bears, force an area: p(x) = W / A + t x (x - c)
 *   tension s = p . n_k, shear q = |p - s n_k|
 *
 * The group breaks off where s + q > strength or -s > compression * strength at some corner of some link of its cut; both are
 * convex in x, so that no place between corners bears more. For a plane cut this is the section of a beam: normal force and
 * bending, by the second moments, make s; transverse force and torsion make q. Every link has its own normal, because the sum of
 * all would vanish where a group is held from two sides, as the crown of an arch is.
 *
 * A group that breaks off takes its weight with it, and no distance elsewhere changes: shortest paths never go through shards that
 * are farther away. One sweep from the farthest level in is therefore the same as starting anew after each group. */
#ifndef SCREE_FROST_STABILITY_H
#define SCREE_FROST_STABILITY_H

#include <scree/frost.h>

#include "allocator.h"

/* What is weighed. Directions need not be unit. */
typedef struct frost_stability_state {
  const uint8_t* states; /* scree_shard_state of each shard */
  const uint8_t* rests;  /* frost_find_rests of this gravity: such shards are the supported ones where none is core */
  const double* lives;   /* of each link */
  double gravity[3];
  double density, strength, compression; /* as in scree_frost_rules; strength > 0 */
} frost_stability_state;

typedef struct frost_stability frost_stability; /* scratch for one simulation, and what its shards' links are to weight */

/* shards: must outlive it. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result frost_stability_create(const scree_shards* shards, const scree_allocator* allocator, frost_stability** out);
void frost_stability_destroy(frost_stability* stability); /* NULL is allowed */
size_t frost_stability_memory(const frost_stability* stability);

/* Of each shard: 1 where it has a vertex within 1e-6 of the solid's extent along gravity from its lowest place. */
void frost_find_rests(const scree_shards_view* view, const double gravity[3], uint8_t* rests);

/* How many groups break off; their cuts' links are then frost_stability_cuts, the farthest group's first, until the next call.
 * Allocates nothing. Time: in proportion to shards and links. */
uint32_t frost_stability_weigh(frost_stability* stability, const frost_stability_state* state);
uint32_t frost_stability_cuts(const frost_stability* stability, const uint32_t** links);

/* Breaks the links of those cuts and counts them in stats.overloaded, until nothing is left to break; returns how many groups that
 * were, 0 where the rules' strength is. Allocates nothing. frost_overload.c. */
uint32_t frost_stability_break(scree_frost* frost);

#endif
