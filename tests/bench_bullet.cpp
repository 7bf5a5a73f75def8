/* scree-bench-pile [NAME] [PACK.scree]: our piles in the hands of a rigid-body engine (Bullet), one JSON object a line.
 *
 * - pile.bullet_drift_*: a cone of rocks as a query delivers it, all of them, stands on a plane and is simulated for two seconds;
 *   how far the rocks' centres of mass move, in diameters of the rock (of the ball of the same volume).
 * - pile.bullet_overlap: the deepest that two hulls reach into each other before anything has moved, cells.
 * - pile.bullet_ratio: as many hulls are dropped from above onto the same plane, between four walls, until they lie still; Bullet's
 *   seconds over those of our query for the cone.
 * - pile.bullet_dropped_*: the drift of that heap over the next two seconds, which is what the engine leaves of a pile at rest.
 *
 * Hulls come from the pack, masses from the rocks' volumes, inertia from the hulls. Rocks of the cone that reach below its base
 * stand in the ground: they do not move. Bullet grows shapes by a margin; the hulls are shrunk by as much first, so that what it
 * sees has the hull's size, with rounded edges. Seconds are the thread's own. */
#define _POSIX_C_SOURCE 200809L
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include <scree/field.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace {

constexpr double kStep = 1.0 / 60, kDriftSeconds = 2, kCap = 12; /* of simulated time */
constexpr float kHeight = 8, kRadius = 16;                       /* of the cone, metres; a cell is one metre */
constexpr double kMargin = 0.01, kDensity = 2600, kFriction = 0.7;
constexpr double kStill = 0.05; /* metres a second, root of the mean square: slower is lying still */

const char* prefix = "";

double seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

[[noreturn]] void die(const char* what) {
  fprintf(stderr, "scree-bench-pile: %s\n", what);
  exit(2);
}

/* Whether some figure that begins so is asked for. */
bool any_wanted(const char* name) {
  const size_t length = std::min(strlen(name), strlen(prefix));
  return strncmp(name, prefix, length) == 0;
}

void report(const char* name, double value, const char* unit, const char* more = "") {
  if (strncmp(name, prefix, strlen(prefix)) != 0) return;
  printf("{\"name\": \"%s\", \"value\": %.4g, \"unit\": \"%s\"%s}\n", name, value, unit, more);
  fflush(stdout);
}

/* What is the same for all rocks of one asset. */
struct rock_shape {
  std::unique_ptr<btConvexHullShape> hull; /* about the centre of mass, along the principal axes */
  btTransform frame;                       /* from those axes to the rock's own */
  btVector3 inertia;
  double mass, diameter, lowest; /* of the hull's vertices, y relative to the home cell's centre */
};

/* Second moments of a solid about the origin, from tetrahedra between it and the faces. */
btMatrix3x3 second_moments(const btConvexHullComputer& hull, double* volume) {
  double sums[3][3] = {};
  *volume = 0;
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* first = &hull.edges[hull.faces[f]];
    const btVector3 a = hull.vertices[first->getSourceVertex()];
    for (const btConvexHullComputer::Edge* e = first->getNextEdgeOfFace(); e->getTargetVertex() != first->getSourceVertex();
         e = e->getNextEdgeOfFace()) {
      const btVector3 b = hull.vertices[e->getSourceVertex()], c = hull.vertices[e->getTargetVertex()], sum = a + b + c;
      const double six = std::fabs(a.dot(b.cross(c)));
      *volume += six / 6;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) sums[i][k] += six / 120 * (a[i] * a[k] + b[i] * b[k] + c[i] * c[k] + sum[i] * sum[k]);
    }
  }
  btMatrix3x3 out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out[i][k] = static_cast<btScalar>(sums[i][k]);
  return out;
}

rock_shape make_shape(const scree_pack* pack, uint32_t lattice_per_cell, uint32_t asset) {
  scree_asset about;
  int16_t xyz[3 * 64];
  uint32_t count = 0;
  if (scree_pack_get_asset(pack, asset, &about) != SCREE_OK || scree_pack_get_hull(pack, asset, xyz, 64, &count) != SCREE_OK)
    die("a rock cannot be read");
  rock_shape shape;
  std::vector<float> points;
  shape.lowest = 0;
  for (uint32_t i = 0; i < 3 * count; ++i) {
    const float at = static_cast<float>(xyz[i]) / static_cast<float>(lattice_per_cell);
    points.push_back(at - about.centroid[i % 3]);
    if (i % 3 == 1) shape.lowest = std::min(shape.lowest, static_cast<double>(at));
  }
  shape.mass = kDensity * about.volume;
  shape.diameter = std::cbrt(6 * about.volume / 3.14159265358979);

  btConvexHullComputer whole;
  whole.compute(points.data(), 3 * sizeof(float), static_cast<int>(count), 0, 0);
  double volume;
  btMatrix3x3 moments = second_moments(whole, &volume), axes;
  moments.diagonalize(axes, btScalar(1e-7), 50);
  const btVector3 m(moments[0][0], moments[1][1], moments[2][2]);
  shape.inertia = btVector3(m.y() + m.z(), m.z() + m.x(), m.x() + m.y()) * static_cast<btScalar>(shape.mass / volume);
  if (axes.determinant() < 0) die("axes are mirrored");
  shape.frame = btTransform(axes);

  btConvexHullComputer shrunk;
  shrunk.compute(points.data(), 3 * sizeof(float), static_cast<int>(count), btScalar(kMargin), btScalar(0.25));
  shape.hull = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < shrunk.vertices.size(); ++i) shape.hull->addPoint(axes.transpose() * shrunk.vertices[i], false);
  shape.hull->recalcLocalAabb();
  shape.hull->setMargin(btScalar(kMargin));
  return shape;
}

struct world {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld bullet{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btStaticPlaneShape>> planes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;

  world() { bullet.setGravity(btVector3(0, btScalar(-9.81), 0)); }
  ~world() {
    for (auto& body : bodies) bullet.removeRigidBody(body.get());
  }

  btRigidBody* add(double mass, const btVector3& inertia, btCollisionShape* shape, const btTransform& place) {
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shape, inertia);
    info.m_startWorldTransform = place;
    info.m_friction = static_cast<btScalar>(std::sqrt(kFriction)); /* Bullet multiplies those of two bodies */
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bullet.addRigidBody(bodies.back().get());
    return bodies.back().get();
  }
  void add_plane(const btVector3& normal, double along) {
    planes.push_back(std::make_unique<btStaticPlaneShape>(normal, static_cast<btScalar>(along)));
    add(0, btVector3(0, 0, 0), planes.back().get(), btTransform::getIdentity());
  }
  void step() { bullet.stepSimulation(btScalar(kStep), 0); }

  double deepest_penetration() {
    double deepest = 0;
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold->getNumContacts(); ++k)
        deepest = std::max(deepest, -static_cast<double>(manifold->getContactPoint(k).getDistance()));
    }
    return deepest;
  }
};

struct pile {
  const scree_pack* pack;
  uint32_t lattice_per_cell;
  std::vector<scree_instance> rocks;
  std::map<uint32_t, rock_shape> shapes;
  double query_seconds;

  rock_shape& shape_of(uint32_t asset) {
    auto found = shapes.find(asset);
    if (found == shapes.end()) found = shapes.emplace(asset, make_shape(pack, lattice_per_cell, asset)).first;
    return found->second;
  }
};

void query_pile(pile* p) {
  scree_field_desc field_desc = {};
  field_desc.pack = p->pack;
  field_desc.seed = 11;
  field_desc.cell_size = 1;
  scree_field* field;
  if (scree_field_create(&field_desc, nullptr, &field) != SCREE_OK) die("no field");
  scree_shape cone = {};
  cone.kind = SCREE_SHAPE_CONE;
  cone.cone.radius = kRadius;
  cone.cone.height = kHeight;
  scree_support_desc support_desc = {};
  support_desc.shapes = &cone;
  support_desc.shape_count = 1;
  scree_support* support;
  if (scree_support_create(&support_desc, nullptr, &support, nullptr) != SCREE_OK) die("no support");
  scree_query_desc query = {};
  query.field = field;
  query.support = support;
  uint64_t count;
  if (scree_query_count(&query, &count) != SCREE_OK) die("no rocks");
  p->rocks.resize(count);
  std::vector<double> times;
  for (int run = 0; run < 101; ++run) {
    const double start = seconds();
    if (scree_query_fill(&query, p->rocks.data(), nullptr, count, &count) != SCREE_OK) die("no rocks");
    times.push_back(seconds() - start);
  }
  std::nth_element(times.begin(), times.begin() + 50, times.end());
  p->query_seconds = times[50];
  scree_support_destroy(support);
  scree_field_destroy(field);
}

btTransform place_of(const scree_asset& about, const rock_shape& shape, const float at[3]) {
  const btVector3 centre(at[0] + about.centroid[0], at[1] + about.centroid[1], at[2] + about.centroid[2]);
  return btTransform(shape.frame.getBasis(), centre);
}

struct mover {
  btRigidBody* body;
  btVector3 start;
  double diameter;
};

double share(const std::vector<double>& sorted, double at) {
  return sorted[std::min(sorted.size() - 1, static_cast<size_t>(at * static_cast<double>(sorted.size())))];
}

/* Simulates two seconds. name: what the names of the figures begin with. */
void measure_drift(world* w, const std::vector<mover>& movers, const char* name, size_t in_ground) {
  const double start = seconds();
  const int steps = static_cast<int>(kDriftSeconds / kStep + 0.5);
  for (int step = 0; step < steps; ++step) w->step();
  const double milliseconds = (seconds() - start) / steps * 1e3;
  std::vector<double> drifts;
  double sum = 0;
  for (const mover& m : movers) {
    drifts.push_back((m.body->getWorldTransform().getOrigin() - m.start).length() / m.diameter);
    sum += drifts.back();
  }
  std::sort(drifts.begin(), drifts.end());
  char more[256];
  snprintf(more, sizeof more, ", \"rocks\": %zu, \"in_ground\": %zu, \"simulated_seconds\": %g, \"step_ms\": %.1f", movers.size(),
           in_ground, kDriftSeconds, milliseconds);
  const std::string begin = name;
  report((begin + "_mean").c_str(), sum / static_cast<double>(drifts.size()), "diameters", more);
  report((begin + "_median").c_str(), share(drifts, 0.5), "diameters", more);
  report((begin + "_p95").c_str(), share(drifts, 0.95), "diameters", more);
  report((begin + "_max").c_str(), drifts.back(), "diameters", more);
}

void bench_drift(pile* p) {
  world w;
  w.add_plane(btVector3(0, 1, 0), 0);
  std::vector<mover> movers;
  for (const scree_instance& rock : p->rocks) {
    scree_asset about;
    scree_pack_get_asset(p->pack, rock.asset, &about);
    const rock_shape& shape = p->shape_of(rock.asset);
    const btTransform place = place_of(about, shape, rock.position);
    const bool in_ground = rock.position[1] + shape.lowest < 0;
    btRigidBody* body = w.add(in_ground ? 0 : shape.mass, shape.inertia, shape.hull.get(), place);
    body->setActivationState(DISABLE_DEACTIVATION);
    if (!in_ground) movers.push_back({body, place.getOrigin(), shape.diameter});
  }
  w.bullet.performDiscreteCollisionDetection();
  report("pile.bullet_overlap", w.deepest_penetration(), "cells");
  if (any_wanted("pile.bullet_drift")) measure_drift(&w, movers, "pile.bullet_drift", p->rocks.size() - movers.size());
}

void bench_drop(pile* p) {
  world w;
  const double half = kRadius * 0.6;
  w.add_plane(btVector3(0, 1, 0), 0);
  w.add_plane(btVector3(1, 0, 0), -half);
  w.add_plane(btVector3(-1, 0, 0), -half);
  w.add_plane(btVector3(0, 0, 1), -half);
  w.add_plane(btVector3(0, 0, -1), -half);
  /* Layers of a loose grid, so that nothing overlaps at first. */
  const double spacing = 2;
  const int row = static_cast<int>(2 * half / spacing);
  int index = 0;
  std::vector<mover> movers;
  for (const scree_instance& rock : p->rocks) {
    const rock_shape& shape = p->shape_of(rock.asset);
    const int x = index % row, z = index / row % row, y = index / (row * row);
    const btVector3 at(btScalar((x + 0.5) * spacing - half), btScalar(1.5 + spacing * y), btScalar((z + 0.5) * spacing - half));
    movers.push_back(
        {w.add(shape.mass, shape.inertia, shape.hull.get(), btTransform(shape.frame.getBasis(), at)), at, shape.diameter});
    ++index;
  }
  const double start = seconds();
  double time = 0, speed;
  do {
    w.step();
    time += kStep;
    double squares = 0;
    for (const auto& body : w.bodies) squares += body->getLinearVelocity().length2();
    speed = std::sqrt(squares / static_cast<double>(p->rocks.size()));
  } while (time < kCap && (time < 1 || speed > kStill));
  const double spent = seconds() - start;
  char more[320];
  snprintf(more, sizeof more,
           ", \"rocks\": %zu, \"bullet_seconds\": %.2f, \"query_seconds\": %.3g, \"simulated_seconds\": %.2f, \"at_rest\": %s, "
           "\"speed_left\": %.3g",
           p->rocks.size(), spent, p->query_seconds, time, speed <= kStill ? "true" : "false", speed);
  report("pile.bullet_ratio", spent / p->query_seconds, "", more);
  if (!any_wanted("pile.bullet_dropped")) return;
  for (mover& m : movers) {
    m.body->forceActivationState(DISABLE_DEACTIVATION);
    m.start = m.body->getWorldTransform().getOrigin();
  }
  measure_drift(&w, movers, "pile.bullet_dropped", 0);
}

}  // namespace

int main(int count, char** arguments) {
  if (count > 1) prefix = arguments[1];
  if (!any_wanted("pile.bullet")) return 0;
  pile p = {};
  scree_pack* pack;
  const char* path = count > 2 ? arguments[2] : "build/packs/boulders.scree";
  if (scree_pack_open_file(path, nullptr, &pack) != SCREE_OK) {
    fprintf(stderr, "scree-bench-pile: %s cannot be opened; ./dev bench bakes it\n", path);
    return 2;
  }
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  p.pack = pack;
  p.lattice_per_cell = info.lattice_per_cell;
  query_pile(&p);
  if (any_wanted("pile.bullet_drift") || any_wanted("pile.bullet_overlap")) bench_drift(&p);
  if (any_wanted("pile.bullet_ratio") || any_wanted("pile.bullet_dropped")) bench_drop(&p);
  scree_pack_close(pack);
  return 0;
}
