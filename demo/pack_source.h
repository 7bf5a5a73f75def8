/* A pack, or models from files, as a source of meshes for the renderer. */
#ifndef PACK_SOURCE_H
#define PACK_SOURCE_H

#include "render.h"
#include "scene_models.h"

/* Reads the record of every asset. out->assets: to be freed with free. The pack must outlive the source. Returns SCREE_OK, CORRUPT,
 * UNSUPPORTED (more levels than RENDER_LODS, which no pack of this version has) or OUT_OF_MEMORY. */
scree_result pack_source(const scree_pack* pack, render_source* out);

/* The same of models from files, which have one level. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result models_source(const scene_models* models, render_source* out);

#endif
