/* The lattice of boxes that other tests stand on. */
#include "make_shards.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

/* Area vector of a polygon, and its contribution to three times the volume. */
static void measure(const scree_shards_view* v, const scree_polygon* p, double area[3], double* volume) {
  const double* first = v->vertices + 3 * (size_t)v->corners[p->first_corner];
  for (int a = 0; a < 3; ++a) area[a] = 0;
  for (uint32_t i = 1; i + 1 < p->corner_count; ++i) {
    const double* b = v->vertices + 3 * (size_t)v->corners[p->first_corner + i];
    const double* c = v->vertices + 3 * (size_t)v->corners[p->first_corner + i + 1];
    for (int a = 0; a < 3; ++a) {
      const int y = (a + 1) % 3, z = (a + 2) % 3;
      area[a] += ((b[y] - first[y]) * (c[z] - first[z]) - (b[z] - first[z]) * (c[y] - first[y])) / 2;
    }
  }
  *volume = first[0] * area[0] + first[1] * area[1] + first[2] * area[2];
}

static void every_box_is_closed_and_has_its_volume(void** state) {
  (void)state;
  const uint32_t size[3] = {4, 3, 5};
  scree_shards* shards = make_lattice(size, 7, NULL);
  const scree_shards_view* v = &shards->view;
  assert_int_equal(v->shard_count, 60);
  double sum = 0;
  for (uint32_t s = 0; s < v->shard_count; ++s) {
    double total[3] = {0}, thrice = 0;
    assert_int_equal(v->shards[s].link_count, 6);
    for (uint32_t k = 0; k < v->shards[s].link_count; ++k) {
      const scree_link* link = &v->links[v->shard_links[v->shards[s].first_link + k]];
      assert_true(link->shards[0] == s || link->shards[1] == s);
      const double sign = link->shards[0] == s ? 1 : -1;
      double of_link[3] = {0};
      for (uint32_t i = 0; i < link->polygon_count; ++i) {
        double area[3], volume;
        measure(v, &v->polygons[link->first_polygon + i], area, &volume);
        thrice += sign * volume;
        for (int a = 0; a < 3; ++a) total[a] += sign * area[a], of_link[a] += area[a];
      }
      for (int a = 0; a < 3; ++a) assert_true(fabs(of_link[a] - link->area * link->normal[a]) < 1e-12);
    }
    for (int a = 0; a < 3; ++a) assert_true(fabs(total[a]) < 1e-12);
    assert_true(fabs(thrice / 3 - v->shards[s].volume) < 1e-12);
    sum += v->shards[s].volume;
  }
  assert_true(fabs(sum - v->volume) < 1e-9);
  scree_shards_destroy(shards);
}

static void links_and_graphs_are_in_order_and_go_both_ways(void** state) {
  (void)state;
  const uint32_t size[3] = {3, 4, 2};
  scree_shards* shards = make_lattice(size, 0, NULL);
  const scree_shards_view* v = &shards->view;
  assert_int_equal(v->link_count - v->interior_link_count, 2 * (3 * 4 + 4 * 2 + 2 * 3));
  for (uint32_t i = 0; i < v->link_count; ++i) {
    const scree_link* link = &v->links[i];
    assert_int_equal(i < v->interior_link_count, link->shards[1] != SCREE_NO_SHARD);
    if (i > 0 && i != v->interior_link_count) assert_true(link[-1].shards[0] <= link->shards[0]);
    if (i > 0 && i < v->interior_link_count && link[-1].shards[0] == link->shards[0])
      assert_true(link[-1].shards[1] < link->shards[1]);
    for (uint32_t k = v->neighbour_first[i]; k < v->neighbour_first[i + 1]; ++k) {
      if (k > v->neighbour_first[i]) assert_true(v->neighbours[k - 1] < v->neighbours[k]);
      const uint32_t other = v->neighbours[k];
      bool back = false;
      for (uint32_t m = v->neighbour_first[other]; m < v->neighbour_first[other + 1]; ++m) back = back || v->neighbours[m] == i;
      assert_true(back);
    }
  }
  /* Links within a box of unit boxes have four neighbours in each of two boxes. */
  for (uint32_t i = 0; i < v->link_count; ++i)
    assert_int_equal(v->neighbour_first[i + 1] - v->neighbour_first[i], i < v->interior_link_count ? 8 : 4);
  scree_shards_destroy(shards);
}

static void the_solid_is_closed(void** state) {
  (void)state;
  const uint32_t size[3] = {3, 2, 4};
  scree_shards* shards = make_lattice(size, 3, NULL);
  const scree_solid* s = shards->view.solid;
  uint8_t* used = calloc((size_t)s->vertex_count * s->vertex_count, 1);
  assert_non_null(used);
  for (uint32_t t = 0; t < 3 * s->triangle_count; ++t) {
    const uint32_t a = s->indices[t], b = s->indices[t % 3 == 2 ? t - 2 : t + 1];
    ++used[(size_t)a * s->vertex_count + b];
  }
  for (uint32_t a = 0; a < s->vertex_count; ++a)
    for (uint32_t b = 0; b < s->vertex_count; ++b) {
      const uint8_t there = used[(size_t)a * s->vertex_count + b], back = used[(size_t)b * s->vertex_count + a];
      assert_int_equal(there, back);
      assert_true(there <= 1);
    }
  free(used);
  scree_shards_destroy(shards);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_box_is_closed_and_has_its_volume),
      cmocka_unit_test(links_and_graphs_are_in_order_and_go_both_ways),
      cmocka_unit_test(the_solid_is_closed),
  };
  return cmocka_run_group_tests_name("make_shards", tests, NULL, NULL);
}
