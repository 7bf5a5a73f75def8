/* What streams and spatial queries ask of a scene: the rocks of a block of cubes of one layer, and the proxies that stand for them
 * far away. Everything here is as pure as the public queries. */
#ifndef SCREE_SCENE_INTERNAL_H
#define SCREE_SCENE_INTERNAL_H

#include <scree/scene.h>

/* As scree_scene_layer, but the field of a scatter is its lattice (scatter_internal.h). */
const scree_layer* scree_rt_scene_layer(const scree_scene* scene, uint32_t index);

/* The rocks whose home cube is in [cube_low, cube_high) of layer `layer` (an index), after filters, the rule of overlaps and edits;
 * with `visible` without those that nobody can see. Positions are relative to `origin`. The order is fixed for given cubes.
 * rocks: in the scratch, until its next use. Returns SCREE_OK, OUT_OF_MEMORY or RANGE. */
scree_result scree_rt_scene_block(const scree_scene* scene, const scree_edits* edits, uint32_t layer, const int32_t cube_low[3],
                                  const int32_t cube_high[3], const double origin[3], bool visible, scree_scratch* scratch,
                                  const scree_rock** rocks, uint64_t* count);

/* The far field. A cube of far level k is 2^k cubes wide, starts where cube 2^k * (x, y, z) of the field does, and has the tile
 * code of corner (x, y, z) and its neighbours: at k = 0 that is the real tile. It is drawn with the proxies of that tile, 2^k times
 * as large: the whole tile where all eight parts exist and are alike to the support, single parts elsewhere. A part exists where
 * the support, the filters (by a hash of the part) and the shell (at least as deep as a part is wide, or surfaces would have holes)
 * say so for its middle; parts whose 26 neighbours exist are left out. Where the support is too thin for middles, parts exist too:
 * those outside by at most half a part's width (times its Lipschitz bound, if that is more than 1), whose middle is nearer than
 * the two beside it along an axis on which the distance rises by at least 0.7 of the most that it does on any. Edits and overlaps
 * are not looked at. Delivered: rock.asset = proxy (scree_pack_proxy), rock.position = where the centre of the tile's cell (0, 0,
 * 0) lies once the mesh is scaled by 2^k, relative to origin; rock.id.cube = the cube at level k, rock.id.local = part. */
scree_result scree_rt_scene_far(const scree_scene* scene, uint32_t layer, uint32_t far_level, const int32_t cube_low[3],
                                const int32_t cube_high[3], const double origin[3], scree_scratch* scratch,
                                const scree_rock** proxies, uint64_t* count);

/* World box of the cubes [cube_low, cube_high) of far level k (0 also for the real cubes): home cells, without what sticks out. */
void scree_rt_scene_cubes_box(const scree_scene* scene, uint32_t layer, uint32_t far_level, const int32_t cube_low[3],
                              const int32_t cube_high[3], double min[3], double max[3]);

/* Whether the layer can have any rock whose home cell's centre lies in a world box; true when in doubt. Costs one evaluation of the
 * support's bounds. */
bool scree_rt_scene_may_hold(const scree_scene* scene, uint32_t layer, const double min[3], const double max[3]);

/* How far, in metres along each axis, a rock can matter to others: a change of the supports in a box can change what is drawn of
 * the layer in that box grown by as much, and nowhere else (burial, radii of rocks). */
double scree_rt_scene_reach(const scree_scene* scene, uint32_t layer);

#endif
