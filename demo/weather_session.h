/* Weathering by hand: a recipe of a hoodoo and the simulation of one of its variants, forwards and back in time.
 *
 * What stands is always what the recipe gives after so many steps. Rules that are changed while it weathers become a phase of the
 * recipe, which begins at that step; going back in time goes to a snapshot and weathers on from there, through the phases that are
 * there now. So a recipe that is saved bakes to what was seen.
 *
 * No window, no OpenGL. Not thread-safe. */
#ifndef WEATHER_SESSION_H
#define WEATHER_SESSION_H

#include <scree/hoodoo.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { WEATHER_SNAPSHOTS = 64 }; /* kept at most; then every other one goes */

typedef struct weather_session weather_session;

/* Does the file look like a recipe of a hoodoo: JSON with "kind": "hoodoo"? False also when it cannot be read. */
bool weather_recipe_is(const char* path);

typedef struct weather_session_desc {
  const char* path; /* of the recipe; copied */
  uint32_t variant;
  uint32_t snapshot_every; /* steps; 0 = 5 */
  scree_jobs jobs;
} weather_session_desc;

/* Returns SCREE_OK or an error with one line that names the file and the key. */
scree_result weather_session_open(const weather_session_desc* desc, weather_session** out, scree_error* error);
void weather_session_close(weather_session* s); /* NULL is allowed */

const scree_hoodoo_recipe* weather_session_recipe(const weather_session* s);
uint32_t weather_session_variant(const weather_session* s);
/* Another variant, at its step 0. On an error the old one stays. */
scree_result weather_session_set_variant(weather_session* s, uint32_t variant, scree_error* error);

/* --- steps --- */

/* One step; none when no rock is left. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result weather_session_step(weather_session* s, scree_error* error);
/* To any step, back or ahead. Ahead it stops early when no rock is left. */
scree_result weather_session_go(weather_session* s, uint32_t step, scree_error* error);
/* The last step that was reached since rules changed: as far as time can be drawn. */
uint32_t weather_session_last(const weather_session* s);
uint32_t weather_session_snapshots(const weather_session* s);
void weather_session_stats(const weather_session* s, scree_weather_stats* out);
uint64_t weather_session_digest(const weather_session* s);

/* --- rules --- */

/* Those that the next step goes by. */
const scree_hoodoo_rules* weather_session_rules(const weather_session* s);
/* Other rules from the next step on. At step 0 they are those of the recipe; later they are a phase. Returns SCREE_OK, RANGE (also
 * when the recipe has no room for one more phase) or OUT_OF_MEMORY; on an error nothing changes. */
scree_result weather_session_set_rules(weather_session* s, const scree_hoodoo_rules* rules, scree_error* error);
/* How many phases of the recipe have begun. */
uint32_t weather_session_phases_begun(const weather_session* s);
/* Takes a phase out of the recipe. Time goes back to before it began, and on to where it was. */
scree_result weather_session_drop_phase(weather_session* s, uint32_t phase, scree_error* error);
/* The rules of now from the start, no phases; time is 0 afterwards. */
scree_result weather_session_flatten(weather_session* s, scree_error* error);
/* Has the recipe changed since it was opened or saved? */
bool weather_session_unsaved(const weather_session* s);

/* --- ages --- */

/* The share that is left, or the step where the recipe counts steps, becomes an age. Returns SCREE_OK or RANGE: it is one already,
 * no room, or no rock. */
scree_result weather_session_keep_age(weather_session* s, scree_error* error);
scree_result weather_session_drop_age(weather_session* s, uint32_t age, scree_error* error);
uint32_t weather_session_ages(const weather_session* s);
/* The step at which an age was reached, false when it was not yet. */
bool weather_session_age_step(const weather_session* s, uint32_t age, uint32_t* step);

/* --- results --- */

/* Writes the recipe, whole or not at all. path: NULL = where it came from. */
scree_result weather_session_save(weather_session* s, const char* path, scree_error* error);
/* Brings the surface up to date; valid until the next call. Lengths in voxels. */
scree_result weather_session_surface(weather_session* s, scree_surface* out, scree_error* error);
/* Writes the surface of now as .glb, in metres, its foot on the origin: one mesh of two primitives, rock and colluvium. */
scree_result weather_session_export(weather_session* s, const char* path, scree_error* error);

#ifdef __cplusplus
}
#endif

#endif
