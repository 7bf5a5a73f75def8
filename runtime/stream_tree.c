/* The octrees. What shall be shown is a cut through each tree: a node is split where its error on the screen is too large. The walk
 * brings what is shown nearer to that, without ever showing less than before: a node stays until all its children have been built
 * and can take its place at once, children stay until their parent can take theirs. A region where nothing is shown yet begins with
 * the coarsest node that lies wholly in view, so that a picture of everything comes first. */
#include <math.h>
#include <string.h>

#include "stream_internal.h"

enum {
  EXPANSIONS = 8192,   /* supports asked about a node, in one update */
  CONTEXT_COVERED = 1, /* an ancestor is shown: this node gets ready, but does not show itself */
  CONTEXT_FROZEN = 2   /* an ancestor wants to take this node's place: nothing new is built */
};

#define OUTSIDE_FRUSTUM 4e6 /* comes after all that is inside */
#define HOLE 1e6            /* where nothing is shown comes before what only gets finer */
#define FIRST_WIDTH 0.5     /* of the view, for what shows itself first */

/* --- distances -------------------------------------------------------------------------------------------------------------- */

double scree_rt_stream_distance(const scree_stream* s, const double low[3], const double high[3], double* scaled) {
  double nearest = INFINITY, nearest_scaled = INFINITY;
  for (uint32_t v = 0; v < s->view_count; ++v) {
    const double* p = s->views[v].position;
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      double d = p[a] < low[a] ? low[a] - p[a] : p[a] > high[a] ? p[a] - high[a] : 0;
      sum += d * d;
    }
    double d = sqrt(sum);
    if (d < nearest) nearest = d;
    if (d * s->views[v].ratio < nearest_scaled) nearest_scaled = d * s->views[v].ratio;
  }
  *scaled = nearest_scaled;
  return nearest;
}

static void node_box(const stream_layer* layer, uint32_t level, const int32_t at[3], double low[3], double high[3]) {
  double width = stream_node_width(layer, level);
  stream_node_low(layer, level, at, low);
  for (int a = 0; a < 3; ++a) high[a] = low[a] + width;
}

/* Whether all of a box is nearer than the limit to one of the views. */
static bool is_wholly_near(const scree_stream* s, const double low[3], const double high[3]) {
  for (uint32_t v = 0; v < s->view_count; ++v) {
    const double* p = s->views[v].position;
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      double d = fmax(fabs(p[a] - low[a]), fabs(p[a] - high[a]));
      sum += d * d;
    }
    if (sqrt(sum) <= s->view_limit) return true;
  }
  return false;
}

/* Whether a node may show itself before its children though a part of it is out of view. */
static bool is_small(const scree_stream* s, const stream_node* node) {
  return node->first && stream_node_width(&s->layers[node->layer], node->level) <= s->view_limit * FIRST_WIDTH;
}

/* Whether no view can see a box. */
static bool is_out_of_sight(const scree_stream* s, const double low[3], const double high[3]) {
  for (uint32_t v = 0; v < s->view_count; ++v) {
    const stream_view* view = &s->views[v];
    bool inside = true;
    for (uint32_t i = 0; i < view->plane_count && inside; ++i) {
      double sum = (double)view->planes[i][3];
      for (int a = 0; a < 3; ++a) {
        double n = (double)view->planes[i][a];
        sum += n * ((n > 0 ? high[a] : low[a]) - view->position[a]);
      }
      inside = sum >= 0;
    }
    if (inside) return false;
  }
  return true;
}

/* Scaled distance nearer than which a node is split. */
static double split_distance(const scree_stream* s, const stream_layer* layer, uint32_t level) {
  const stream_pack* pack = &s->packs[layer->pack];
  /* Parts, half a cube wide, exist or not: surfaces lie a quarter of that off on average. */
  float error = fmaxf(pack->far_error, (float)layer->field->cells_per_cube * 0.125f);
  double metres = (double)error * (double)layer->cell * (double)(1u << (level - 1));
  return metres * s->pixels / ((double)s->desc.max_error_pixels * s->split_scale);
}

/* --- holes ------------------------------------------------------------------------------------------------------------------ */

/* Of a node that is not shown: what once gave way to children shows nothing only because they have nothing. */
static bool is_hole(const stream_node* node, uint8_t context) {
  return !(context & CONTEXT_COVERED) && node->shown_below == 0 && !node->opened;
}

static void set_hole(scree_stream* s, uint32_t number, bool hole) {
  stream_node* node = &s->nodes[number];
  if (hole == (node->hole_at != STREAM_NONE)) return;
  if (hole) {
    node->hole_at = s->hole_count;
    s->holes[s->hole_count++] = number;
  } else {
    uint32_t last = s->holes[--s->hole_count];
    s->holes[node->hole_at] = last;
    s->nodes[last].hole_at = node->hole_at;
    node->hole_at = STREAM_NONE;
  }
}

double scree_rt_stream_covered(const scree_stream* s) {
  double covered = s->view_limit;
  for (uint32_t i = 0; i < s->hole_count; ++i) {
    const stream_node* node = &s->nodes[s->holes[i]];
    double low[3], high[3], scaled;
    node_box(&s->layers[node->layer], node->level, node->at, low, high);
    covered = fmin(covered, scree_rt_stream_distance(s, low, high, &scaled));
  }
  return s->view_count > 0 ? covered : s->desc.view_distance;
}

/* --- nodes ------------------------------------------------------------------------------------------------------------------ */

static uint32_t take_node(scree_stream* s) {
  uint32_t number = s->free_node;
  if (number != STREAM_NONE) {
    s->free_node = s->nodes[number].next;
  } else {
    if (s->node_used == s->node_count) return STREAM_NONE;
    number = s->node_used++;
    s->nodes[number].generation = 0;
  }
  stream_node* node = &s->nodes[number];
  uint32_t generation = node->generation;
  memset(node, 0, sizeof *node);
  node->generation = generation;
  node->due = -INFINITY;
  node->parent = node->next = node->block = node->fresh = node->hole_at = STREAM_NONE;
  for (int i = 0; i < 8; ++i) {
    node->child[i] = STREAM_NONE;
    node->child_due[i] = -INFINITY;
  }
  return number;
}

/* Makes a node where the layer can have rocks. Returns STREAM_NONE where it cannot (*empty) or when there is no room. */
static uint32_t make_node(scree_stream* s, uint32_t layer, uint32_t level, const int32_t at[3], uint32_t parent, bool* empty) {
  double low[3], high[3];
  *empty = true;
  int64_t width = (int64_t)STREAM_BLOCK_CUBES << level;
  for (int a = 0; a < 3; ++a)
    if (at[a] * width < INT32_MIN || at[a] * width + width > INT32_MAX) return STREAM_NONE;
  node_box(&s->layers[layer], level, at, low, high);
  if (!scree_rt_scene_may_hold(s->scene, layer, low, high)) return STREAM_NONE;
  *empty = false;
  uint32_t number = take_node(s);
  if (number == STREAM_NONE) {
    s->short_of_room = true;
    return STREAM_NONE;
  }
  stream_node* node = &s->nodes[number];
  memcpy(node->at, at, sizeof node->at);
  node->layer = (uint16_t)layer;
  node->level = (uint8_t)level;
  node->parent = parent;
  node->touched = s->touch;
  node->first = parent == STREAM_NONE || (s->nodes[parent].first && !s->nodes[parent].opened && s->nodes[parent].shown_below == 0);
  return number;
}

static void unlink_root(scree_stream* s, uint32_t number) {
  uint32_t* link = &s->grave;
  for (uint32_t i = 0; i <= s->layer_count; ++i) {
    for (link = i < s->layer_count ? &s->layers[i].root : &s->grave; *link != STREAM_NONE; link = &s->nodes[*link].next)
      if (*link == number) {
        *link = s->nodes[number].next;
        return;
      }
  }
}

static void free_node(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  if (node->parent == STREAM_NONE) {
    unlink_root(s, number);
  } else {
    stream_node* parent = &s->nodes[node->parent];
    for (int i = 0; i < 8; ++i)
      if (parent->child[i] == number) {
        parent->child[i] = STREAM_NONE;
        parent->child_due[i] = -INFINITY;
      }
  }
  if (node->refused) --s->refused;
  set_hole(s, number, false);
  ++node->generation;
  node->next = s->free_node;
  s->free_node = number;
}

static bool hide_now(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  if (!node->shown) return true;
  if (node->block != STREAM_NONE && !scree_rt_stream_can_send(s, 1, stream_run_bytes(&s->blocks[node->block]))) return false;
  scree_rt_stream_hide(s, number);
  return true;
}

/* Takes a subtree away, its root too unless it is `kept`. False when not all events could be sent: then some of it is left. */
static bool prune(scree_stream* s, uint32_t number, bool kept) {
  stream_node* node = &s->nodes[number];
  for (int i = 0; i < 8; ++i)
    if (node->child[i] != STREAM_NONE && !prune(s, node->child[i], false)) return false;
  if (kept) return true;
  if (!hide_now(s, number)) return false;
  scree_rt_stream_drop_fresh(s, node);
  free_node(s, number);
  return true;
}

/* --- wants ------------------------------------------------------------------------------------------------------------------ */

static bool comes_later(const stream_want* a, const stream_want* b) {
  return a->order != b->order ? a->order > b->order : a->node > b->node;
}

static void sift_down(stream_want* heap, uint32_t count, uint32_t at) {
  for (;;) {
    uint32_t largest = at, left = 2 * at + 1, right = left + 1;
    if (left < count && comes_later(&heap[left], &heap[largest])) largest = left;
    if (right < count && comes_later(&heap[right], &heap[largest])) largest = right;
    if (largest == at) return;
    stream_want swapped = heap[at];
    heap[at] = heap[largest];
    heap[largest] = swapped;
    at = largest;
  }
}

/* Keeps the wants that come first, as many as can be built now. */
static void want(scree_stream* s, uint32_t number, double order) {
  stream_want entry = {order, number};
  if (s->want_count < s->want_room) {
    uint32_t at = s->want_count++;
    s->wants[at] = entry;
    while (at > 0 && comes_later(&s->wants[at], &s->wants[(at - 1) / 2])) {
      stream_want swapped = s->wants[at];
      s->wants[at] = s->wants[(at - 1) / 2];
      s->wants[(at - 1) / 2] = swapped;
      at = (at - 1) / 2;
    }
  } else if (s->want_count > 0 && comes_later(&s->wants[0], &entry)) {
    s->wants[0] = entry;
    sift_down(s->wants, s->want_count, 0);
  }
}

static void build_wants(scree_stream* s) {
  for (uint32_t count = s->want_count; count > 1; --count) { /* sorted: the first to be built is the first */
    stream_want last = s->wants[0];
    s->wants[0] = s->wants[count - 1];
    s->wants[count - 1] = last;
    sift_down(s->wants, count - 1, 0);
  }
  for (uint32_t i = 0; i < s->want_count; ++i) scree_rt_stream_build_start(s, s->wants[i].node);
  s->want_count = 0;
}

/* --- taking each other's place ---------------------------------------------------------------------------------------------- */

/* A node takes the place of all that is shown below it. */
static bool try_show(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  if (!scree_rt_stream_coarsest_are_in(s, node->layer, node->level)) return false;
  uint32_t events = node->shown_below + 1;
  uint64_t bytes = scree_rt_stream_fresh_bytes(s, node) + (uint64_t)node->shown_below * sizeof(scree_stream_run) * STREAM_CLASSES;
  if (!scree_rt_stream_can_send(s, events, bytes)) {
    if (events > s->desc.caps.events || bytes > s->desc.caps.upload_bytes) prune(s, number, true); /* never at once */
    return false;
  }
  prune(s, number, true);
  node->opened = false;
  scree_rt_stream_show(s, number);
  return true;
}

/* The children take the place of the node. */
static bool try_split(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  if (!scree_rt_stream_coarsest_are_in(s, node->layer, node->level - 1u)) return false;
  uint32_t events = 1;
  uint64_t bytes = sizeof(scree_stream_run) * STREAM_CLASSES;
  for (int i = 0; i < 8; ++i) {
    if (node->child[i] == STREAM_NONE) continue;
    const stream_node* child = &s->nodes[node->child[i]];
    ++events;
    bytes += scree_rt_stream_fresh_bytes(s, child);
  }
  if (!scree_rt_stream_can_send(s, events, bytes)) {
    if (events > s->desc.caps.events || bytes > s->desc.caps.upload_bytes) hide_now(s, number); /* then they come one by one */
    return false;
  }
  scree_rt_stream_hide(s, number);
  node->opened = true;
  for (int i = 0; i < 8; ++i)
    if (node->child[i] != STREAM_NONE && s->nodes[node->child[i]].ready) scree_rt_stream_show(s, node->child[i]);
  return true;
}

/* --- the walk --------------------------------------------------------------------------------------------------------------- */

static double visit(scree_stream* s, uint32_t number, uint8_t context);

static double pend(scree_stream* s) {
  ++s->pending;
  return -INFINITY;
}

/* The order in which nodes are built: holes first, then how far away they are, in their own widths. */
static double build_order(const scree_stream* s, const stream_node* node, const double low[3], const double high[3],
                          double scaled) {
  double order = scaled / stream_node_width(&s->layers[node->layer], node->level);
  if (is_hole(node, node->context)) order -= HOLE;
  return is_out_of_sight(s, low, high) ? order + OUTSIDE_FRUSTUM : order;
}

/* Visits the children there are. */
static double visit_children(scree_stream* s, uint32_t number, uint8_t context) {
  double due = INFINITY;
  s->nodes[number].child_context = context;
  for (int i = 0; i < 8; ++i) {
    uint32_t child = s->nodes[number].child[i];
    if (child != STREAM_NONE) due = fmin(due, visit(s, child, context));
  }
  return due;
}

/* A shown node whose rocks have changed. */
static double renew(scree_stream* s, uint32_t number, double order) {
  stream_node* node = &s->nodes[number];
  if (node->ready) {
    if (node->block != STREAM_NONE && s->blocks[node->block].sent == s->update) return pend(s);
    if (!scree_rt_stream_can_send(s, 1, scree_rt_stream_fresh_bytes(s, node))) return pend(s);
    scree_rt_stream_replace(s, number);
    return s->travel;
  }
  if (!node->building) want(s, number, order);
  return pend(s);
}

/* Node that shall show itself. */
static double visit_leaf(scree_stream* s, uint32_t number, uint8_t context, double order) {
  stream_node* node = &s->nodes[number];
  node->split = false;
  if (!node->shown) {
    if (!node->ready && !node->building) want(s, number, order);
    if (!(context & CONTEXT_COVERED) && node->ready && try_show(s, number)) {
      set_hole(s, number, false);
      return INFINITY;
    }
    set_hole(s, number, is_hole(node, context));
    visit_children(s, number, CONTEXT_FROZEN);
    /* Under an ancestor that is shown, a node that is ready waits for its siblings; the ancestor is pending for it. */
    return pend(s);
  }
  set_hole(s, number, node->refused);
  double due = INFINITY;
  for (int i = 0; i < 8; ++i)
    if (node->child[i] != STREAM_NONE && !prune(s, node->child[i], false)) due = pend(s);
  if (node->stale) due = fmin(due, renew(s, number, order));
  return due;
}

static double child_distance(const scree_stream* s, const stream_node* node, int i) {
  int32_t at[3];
  double low[3], high[3], scaled;
  for (int a = 0; a < 3; ++a) at[a] = node->at[a] * 2 + (i >> a & 1);
  node_box(&s->layers[node->layer], node->level - 1u, at, low, high);
  return scree_rt_stream_distance(s, low, high, &scaled);
}

/* A block that has nothing to do but to go out of view: stream_watch.c tells when. */
static bool is_settled(const stream_node* node) {
  return node->level == 0 && node->shown && node->block != STREAM_NONE && !node->stale && node->context == 0;
}

/* The child at place i of a split node, made if it may hold something. *due: when it may come into view. */
static uint32_t child_of(scree_stream* s, uint32_t number, int i, bool* missing, double* due) {
  stream_node* node = &s->nodes[number];
  if (node->child[i] != STREAM_NONE || (node->empty >> i & 1)) return node->child[i];
  double distance = child_distance(s, node, i);
  if (distance > s->view_limit) {
    *due = fmin(*due, s->travel + distance - s->view_limit);
    return STREAM_NONE;
  }
  *missing = true;
  if (s->expansions == 0) return STREAM_NONE;
  --s->expansions;
  int32_t at[3];
  for (int a = 0; a < 3; ++a) at[a] = node->at[a] * 2 + (i >> a & 1);
  bool empty;
  uint32_t child = make_node(s, node->layer, node->level - 1u, at, number, &empty);
  if (empty) {
    node->empty |= (uint8_t)(1u << i);
    *missing = false;
  }
  if (child == STREAM_NONE) return STREAM_NONE;
  *missing = false;
  s->nodes[number].child[i] = child;
  return child;
}

static double visit_split(scree_stream* s, uint32_t number, uint8_t context) {
  stream_node* node = &s->nodes[number];
  node->split = true;
  if (!node->shown && node->ready) scree_rt_stream_drop_fresh(s, node);
  uint8_t below = context & CONTEXT_COVERED || node->shown ? CONTEXT_COVERED : 0;
  double due = INFINITY;
  bool all_ready = true, any_missing = false;
  bool known = !s->revisit && node->child_context == below;
  for (int i = 0; i < 8; ++i)
    if (node->child[i] != STREAM_NONE && node->child_due[i] <= s->travel) stream_prefetch(&s->nodes[node->child[i]], sizeof *node);
  node->child_context = below;
  for (int i = 0; i < 8; ++i) {
    if (!known || node->child_due[i] <= s->travel) {
      bool missing = false;
      double child_due = INFINITY;
      uint32_t child = child_of(s, number, i, &missing, &child_due);
      if (missing) {
        child_due = pend(s);
        any_missing = true;
      }
      if (child != STREAM_NONE) child_due = visit(s, child, below);
      if (child_due > s->travel && node->child[i] != STREAM_NONE && is_settled(&s->nodes[node->child[i]])) child_due = INFINITY;
      node->child_due[i] = child_due;
    }
    if (node->child_due[i] < due) due = node->child_due[i];
    if (!node->shown || node->child[i] == STREAM_NONE) continue;
    const stream_node* child = &s->nodes[node->child[i]];
    if (!child->shown && !child->ready) all_ready = false;
  }
  if (any_missing) all_ready = false;
  set_hole(s, number, any_missing && below == 0);
  if (!node->shown) {
    if (due > s->travel) node->opened = true; /* all there is below is there, if only nothing */
    return due;
  }
  if (!all_ready || !try_split(s, number)) return pend(s);
  return -INFINITY; /* children are no longer covered */
}

/* Lets go of what was built for a node that shall only keep what it shows. */
static double visit_frozen(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  if (!node->shown && node->ready) scree_rt_stream_drop_fresh(s, node);
  return visit_children(s, number, CONTEXT_FROZEN);
}

/* A block that was built and has nothing in it is not looked at again. */
static bool is_void(const stream_node* node) {
  if (node->level > 0 || node->parent == STREAM_NONE || node->stale || node->refused) return false;
  return node->shown ? node->block == STREAM_NONE : node->ready && node->fresh == STREAM_NONE;
}

static double visit(scree_stream* s, uint32_t number, uint8_t context) {
  stream_node* node = &s->nodes[number];
  if (!s->revisit && node->due > s->travel && node->context == context) return node->due;
  const stream_layer* layer = &s->layers[node->layer];
  double low[3], high[3], scaled;
  node_box(layer, node->level, node->at, low, high);
  double distance = scree_rt_stream_distance(s, low, high, &scaled);
  if (distance > s->view_limit) {
    if (prune(s, number, false)) return s->travel + distance - s->view_limit; /* it may come back then */
    return pend(s);
  }
  double due = s->travel + s->view_limit - distance;
  node->context = context;
  if (context & CONTEXT_FROZEN) {
    due = fmin(due, visit_frozen(s, number));
  } else {
    bool split = node->level > 0;
    if (split && layer->far_field) {
      double near = split_distance(s, layer, node->level), far = near * (1 + (double)s->desc.hysteresis);
      split = scaled < (node->split ? far : near);
      due = fmin(due, s->travel + (split ? far - scaled : scaled - near));
      if (split && (context & CONTEXT_COVERED)) split = false;
      if (split && node->shown_below == 0 && !node->opened && (is_small(s, node) || is_wholly_near(s, low, high))) {
        split = false;
        due = pend(s); /* it shows itself first, and is split then */
      }
    }
    double order = build_order(s, node, low, high, scaled);
    due = fmin(due, split ? visit_split(s, number, context) : visit_leaf(s, number, context, order));
  }
  if (is_void(node)) {
    stream_node* parent = &s->nodes[node->parent];
    uint32_t i = (uint32_t)((node->at[0] & 1) | (node->at[1] & 1) << 1 | (node->at[2] & 1) << 2);
    if (prune(s, number, false)) {
      parent->empty |= (uint8_t)(1u << i);
      return INFINITY;
    }
  }
  node->due = due;
  return due;
}

void scree_rt_stream_node_due(scree_stream* s, uint32_t number) {
  for (uint32_t n = number; n != STREAM_NONE; n = s->nodes[n].parent) {
    stream_node* node = &s->nodes[n];
    node->due = -INFINITY;
    if (node->parent == STREAM_NONE) continue;
    s->nodes[node->parent].child_due[(node->at[0] & 1) | (node->at[1] & 1) << 1 | (node->at[2] & 1) << 2] = -INFINITY;
  }
}

/* --- roots ------------------------------------------------------------------------------------------------------------------ */

static bool has_root(const scree_stream* s, const stream_layer* layer, const int32_t at[3]) {
  for (uint32_t n = layer->root; n != STREAM_NONE; n = s->nodes[n].next)
    if (memcmp(s->nodes[n].at, at, sizeof s->nodes[n].at) == 0) return true;
  return false;
}

/* Makes the roots that are in view. */
static void find_roots(scree_stream* s, uint32_t index) {
  stream_layer* layer = &s->layers[index];
  double width = stream_node_width(layer, layer->top), reach = s->view_limit;
  layer->root_due = s->travel + width * 0.25;
  for (uint32_t v = 0; v < s->view_count; ++v) {
    double from[3], to[3];
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      from[a] = floor((s->views[v].position[a] - reach - layer->low[a]) / width - 0.25);
      to[a] = floor((s->views[v].position[a] + reach - layer->low[a]) / width + 0.25);
      inside = inside && from[a] > -2e9 && to[a] < 2e9;
    }
    if (!inside) continue; /* beyond the cubes of the field */
    for (int32_t z = (int32_t)from[2]; z <= (int32_t)to[2]; ++z)
      for (int32_t y = (int32_t)from[1]; y <= (int32_t)to[1]; ++y)
        for (int32_t x = (int32_t)from[0]; x <= (int32_t)to[0]; ++x) {
          const int32_t at[3] = {x, y, z};
          double low[3], high[3], scaled;
          node_box(layer, layer->top, at, low, high);
          double distance = scree_rt_stream_distance(s, low, high, &scaled);
          if (distance > s->view_limit) {
            layer->root_due = fmin(layer->root_due, s->travel + distance - s->view_limit);
            continue;
          }
          if (has_root(s, layer, at)) continue;
          bool empty;
          uint32_t root = make_node(s, index, layer->top, at, STREAM_NONE, &empty);
          if (root == STREAM_NONE) {
            if (!empty) layer->root_due = s->travel;
            continue;
          }
          s->nodes[root].next = layer->root;
          layer->root = root;
        }
  }
}

/* --- bounds ----------------------------------------------------------------------------------------------------------------- */

static bool has_far_field(const scree_stream* s) {
  for (uint32_t i = 0; i < s->layer_count; ++i)
    if (s->layers[i].far_field) return true;
  return false;
}

/* What only fades out goes at once. */
static void end_leaving(scree_stream* s) {
  for (uint32_t i = s->fading_count; i-- > 0;)
    if (s->blocks[s->fading[i]].leaving && scree_rt_stream_can_send(s, 1, 0)) scree_rt_stream_block_out(s, s->fading[i]);
}

/* Whether what gave way under a cap may come back by a step: a little after the last one, or as soon as everything is there while
 * the views stand still; but not there where that was too much before. */
static bool may_relax(const scree_stream* s, const stream_bound* b) {
  bool settled = s->pending == 0 && s->build_queue.count == 0 && s->decodes_under_way == 0;
  return s->travel >= b->wait || (settled && s->travel >= b->refused);
}

static void tightened(const scree_stream* s, stream_bound* b) {
  b->wait = s->travel + s->view_limit * 0.02;
  if (s->travel < b->relaxed) b->refused = b->wait;
}

static void relaxed(const scree_stream* s, stream_bound* b) {
  b->wait = s->travel + s->view_limit * 0.01; /* what was let in by the last step is there by then */
  b->relaxed = s->travel + s->view_limit * 0.02;
}

/* When a cap binds, what is farthest gives way: first to proxies, then altogether. When there is room again, it comes back. */
static void bound(scree_stream* s) {
  const double step = 1.03, relax = 1.02, most = 64;
  const scree_stream_caps* caps = &s->desc.caps;
  if (s->short_of_room) {
    tightened(s, &s->room_bound);
    end_leaving(s);
    if (has_far_field(s) && s->split_scale < most)
      s->split_scale *= step;
    else
      s->view_limit /= step;
    s->revisit_next = true;
  } else if ((s->split_scale > 1 || s->view_limit < s->desc.view_distance) && may_relax(s, &s->room_bound)) {
    bool room = s->ranges.free_units > s->ranges.units / 8 && s->blocks_used - s->blocks_free < caps->blocks - caps->blocks / 8;
    if (room) {
      if (s->view_limit < s->desc.view_distance)
        s->view_limit = fmin(s->view_limit * relax, s->desc.view_distance);
      else
        s->split_scale = fmax(s->split_scale / relax, 1);
      relaxed(s, &s->room_bound);
      s->revisit_next = true;
    }
  }
  if (s->short_of_meshes) {
    tightened(s, &s->mesh_bound);
    if (s->mesh_scale < 1e6) s->mesh_scale *= step;
    s->revisit_next = true;
  } else if (s->mesh_scale > 1 && may_relax(s, &s->mesh_bound) &&
             s->mesh_bytes - s->idle_bytes < caps->mesh_bytes - caps->mesh_bytes / 8) {
    s->mesh_scale = fmax(s->mesh_scale / relax, 1);
    relaxed(s, &s->mesh_bound);
    s->revisit_next = true;
  }
}

void scree_rt_stream_tree_update(scree_stream* s) {
  s->pending = 0;
  s->moved_count = 0;
  s->expansions = EXPANSIONS;
  s->want_count = 0;
  s->want_room = s->build_queue.free_count;
  s->revisit = s->revisit || s->revisit_next;
  s->revisit_next = false;
  while (s->grave != STREAM_NONE && prune(s, s->grave, false)) continue;
  if (s->grave != STREAM_NONE) ++s->pending;
  for (uint32_t i = 0; i < s->layer_count; ++i) {
    stream_layer* layer = &s->layers[i];
    if (s->revisit || s->travel >= layer->root_due) find_roots(s, i);
    if (!scree_rt_stream_coarsest_are_in(s, i, 0) || !scree_rt_stream_coarsest_are_in(s, i, 1)) ++s->pending;
    for (uint32_t root = layer->root; root != STREAM_NONE;) {
      uint32_t next = s->nodes[root].next, generation = s->nodes[root].generation;
      double due = visit(s, root, 0);
      if (s->nodes[root].generation != generation) layer->root_due = fmin(layer->root_due, due);
      root = next;
    }
  }
  build_wants(s);
}

void scree_rt_stream_bound(scree_stream* s) {
  bound(s);
  s->revisit = s->short_of_room = s->short_of_meshes = false;
}

/* --- changes ---------------------------------------------------------------------------------------------------------------- */

static void touch_node(scree_stream* s, uint32_t number, const double min[3], const double max[3]) {
  stream_node* node = &s->nodes[number];
  double low[3], high[3];
  node_box(&s->layers[node->layer], node->level, node->at, low, high);
  /* Far cubes are decided by the middles of their parts, which are as wide as a quarter of the node's eighth. */
  double grow = node->level > 0 ? stream_node_width(&s->layers[node->layer], node->level) / 8 : 0;
  for (int a = 0; a < 3; ++a)
    if (min != NULL && (low[a] - grow > max[a] || high[a] + grow < min[a])) return;
  node->due = -INFINITY;
  node->touched = s->touch;
  for (int i = 0; i < 8; ++i) node->child_due[i] = -INFINITY;
  node->empty = 0;
  node->opened = false;
  if (node->shown) node->stale = true;
  scree_rt_stream_drop_fresh(s, node);
  for (int i = 0; i < 8; ++i)
    if (node->child[i] != STREAM_NONE) touch_node(s, node->child[i], min, max);
}

void scree_rt_stream_touch(scree_stream* s, uint32_t layer, const double min[3], const double max[3]) {
  s->layers[layer].root_due = -INFINITY;
  for (uint32_t n = s->layers[layer].root; n != STREAM_NONE; n = s->nodes[n].next) touch_node(s, n, min, max);
}

static void forget_builds(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  ++node->generation;
  node->building = false;
  scree_rt_stream_drop_fresh(s, node);
  for (int i = 0; i < 8; ++i)
    if (node->child[i] != STREAM_NONE) forget_builds(s, node->child[i]);
}

void scree_rt_stream_bury(scree_stream* s, uint32_t layer) {
  while (s->layers[layer].root != STREAM_NONE) {
    uint32_t root = s->layers[layer].root;
    s->layers[layer].root = s->nodes[root].next;
    forget_builds(s, root);
    s->nodes[root].next = s->grave;
    s->grave = root;
  }
}
