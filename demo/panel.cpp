#include "panel.h"

#include <dirent.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include "panel_frame.h"
#include "stage.h"
#include "view_options.h"

struct panel {
  ImGuiContext* context;
  bool edited;  // since the last committed step
  std::vector<std::string> packs;
  double packs_read;  // time of the last look into the folder
};

namespace {

// Names of the packs in the folder, without their ending.
void read_packs(panel* p, const char* folder) {
  p->packs.clear();
  DIR* directory = opendir(folder);
  if (directory == nullptr) return;
  while (const dirent* entry = readdir(directory)) {
    std::string name = entry->d_name;
    if (name.size() > 6 && name.compare(name.size() - 6, 6, ".scree") == 0) p->packs.push_back(name.substr(0, name.size() - 6));
  }
  closedir(directory);
  std::sort(p->packs.begin(), p->packs.end());
}

bool drag(const char* label, double* value, double speed, double low, double high, const char* format = "%.3f") {
  return ImGui::DragScalar(label, ImGuiDataType_Double, value, static_cast<float>(speed), &low, &high, format,
                           ImGuiSliderFlags_AlwaysClamp);
}

// Limits as in scene_read.c: a number typed in by hand must not make a scene that cannot be opened again.
bool drag3(const char* label, double* values, double speed, double limit, const char* format = "%.2f") {
  const double low = -limit;
  return ImGui::DragScalarN(label, ImGuiDataType_Double, values, 3, static_cast<float>(speed), &low, &limit, format,
                            ImGuiSliderFlags_AlwaysClamp);
}

const double kSmall = 1e-3, kLarge = 1e4, kNear = 1e6, kFar = 1e9, kTurns = 36000;

// The points of an extrusion, a tube or blobs: each can be moved, each can go, a new one comes between two or at the end.
bool point_widgets(scene_node* node) {
  const bool corners = node->kind == SCREE_SHAPE_EXTRUSION;
  const scene_point_limits limits = scene_kind_points(node->kind);
  bool changed = false;
  for (uint32_t i = 0; i < node->point_count; ++i) {
    scene_point* point = &node->points[i];
    ImGui::PushID(static_cast<int>(i));
    ImGui::PushItemWidth(-90);
    if (corners) {
      double xz[2] = {point->place[0], point->place[2]};
      const double low = -kNear, high = kNear;
      if (ImGui::DragScalarN("##corner", ImGuiDataType_Double, xz, 2, 0.02f, &low, &high, "%.2f", ImGuiSliderFlags_AlwaysClamp)) {
        point->place[0] = xz[0];
        point->place[2] = xz[1];
        changed = true;
      }
    } else {
      changed |= drag3("##place", point->place, 0.02, kNear);
    }
    ImGui::PopItemWidth();
    ImGui::SameLine();
    if (node->point_count < limits.most && ImGui::SmallButton("+")) {
      // Halfway to the next point; behind the last, as far again.
      const bool last = i + 1 == node->point_count;
      const scene_point other = node->points[last ? (i > 0 ? i - 1 : i) : i + 1];
      scene_point added = *point;
      for (int a = 0; a < 3; ++a)
        added.place[a] += last && !corners ? point->place[a] - other.place[a] : 0.5 * (other.place[a] - point->place[a]);
      if (last && node->point_count == 1) added.place[0] += 0.5 * point->radius;
      changed |= scene_node_add_point(node, i + 1, &added);
      point = &node->points[i];
    }
    ImGui::SameLine();
    const bool gone = node->point_count > limits.least && ImGui::SmallButton("x") && scene_node_remove_point(node, i);
    if (!gone && !corners) changed |= drag("radius", &point->radius, 0.02, kSmall, kLarge);
    ImGui::PopID();
    changed |= gone;
    if (gone) break;
  }
  return changed;
}

bool count_widget(const char* label, uint32_t* value, uint32_t low, uint32_t high) {
  return ImGui::SliderScalar(label, ImGuiDataType_U32, value, &low, &high, "%u", ImGuiSliderFlags_AlwaysClamp);
}

bool pattern_widgets(scene_node* node) {
  static const char* const words[] = {"lines", "rings", "waves"};
  int kind = node->pattern.kind;
  bool changed = ImGui::Combo("pattern", &kind, words, 3);
  node->pattern.kind = static_cast<scree_pattern_kind>(kind);
  changed |= drag("spacing", &node->pattern.spacing, 0.01, kSmall, kLarge);
  changed |= drag("bars", &node->pattern.radius, 0.005, kSmall, kLarge);
  if (node->pattern.kind != SCREE_PATTERN_WAVES) return changed;
  changed |= drag("swing", &node->pattern.amplitude, 0.01, 0, kLarge);
  return drag("wavelength", &node->pattern.wavelength, 0.02, kSmall, kLarge) || changed;
}

void tooltip(const char* text) {
  if (!ImGui::IsItemHovered() || ImGui::IsItemActive()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(360);
  ImGui::TextUnformatted(text);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

// One of the times that the pack of a cliff keeps.
bool time_widget(uint32_t* value, uint32_t times) {
  const uint32_t before = *value, low = 0, high = times - 1;
  ImGui::SliderScalar("time", ImGuiDataType_U32, value, &low, &high, "%u", ImGuiSliderFlags_AlwaysClamp);
  return *value != before;
}

bool mesh_widgets(scene_mesh* mesh, uint32_t times) {
  ImGui::TextDisabled("%s", mesh->pack[0] != '\0' ? mesh->pack : mesh->file);
  if (times < 2) return false;  // nothing to choose
  const bool changed = time_widget(&mesh->time, times);
  tooltip("Moves this shape alone. The time of a field that shows the cliff moves all of its parts.");
  return changed;
}

bool shape_widgets(scene_node* node, uint32_t mesh_times) {
  bool changed = false;
  switch (node->kind) {
    case SCREE_SHAPE_SPHERE: changed |= drag("radius", &node->sphere.radius, 0.02, kSmall, kLarge); break;
    case SCREE_SHAPE_BOX: {
      changed |= drag3("half", node->box.half, 0.02, kLarge);
      double smallest = kLarge;
      for (double& half : node->box.half) {
        half = std::clamp(half, kSmall, kLarge);
        smallest = std::min(smallest, half);
      }
      changed |= drag("rounding", &node->box.rounding, 0.01, 0, smallest);
      node->box.rounding = std::min(node->box.rounding, smallest);
      break;
    }
    case SCREE_SHAPE_CAPSULE:
      changed |= drag3("from", node->capsule.a, 0.02, kFar);
      changed |= drag3("to", node->capsule.b, 0.02, kFar);
      changed |= drag("radius", &node->capsule.radius, 0.02, kSmall, kLarge);
      break;
    case SCREE_SHAPE_CYLINDER:
      changed |= drag("radius", &node->cylinder.radius, 0.02, kSmall, kLarge);
      changed |= drag("half height", &node->cylinder.half_height, 0.02, kSmall, kLarge);
      break;
    case SCREE_SHAPE_CONE:
      changed |= drag("radius", &node->cone.radius, 0.02, kSmall, kLarge);
      changed |= drag("height", &node->cone.height, 0.02, kSmall, kLarge);
      break;
    case SCREE_SHAPE_HEIGHTFIELD:
      ImGui::TextDisabled("%s", node->heightfield.map.file);
      changed |= drag("above", &node->heightfield.above, 0.02, -kLarge, kLarge);
      changed |= drag("below", &node->heightfield.below, 0.02, -node->heightfield.above + kSmall, kLarge);
      break;
    case SCREE_SHAPE_MESH: changed |= mesh_widgets(&node->mesh, mesh_times); break;
    case SCREE_SHAPE_ELLIPSOID:
      changed |= drag3("radii", node->ellipsoid.radii, 0.02, kLarge);
      for (double& radius : node->ellipsoid.radii) radius = std::clamp(radius, kSmall, kLarge);
      break;
    case SCREE_SHAPE_TORUS:
      changed |= drag("radius", &node->torus.radius, 0.02, kSmall, kLarge);
      changed |= drag("tube radius", &node->torus.tube_radius, 0.01, kSmall, kLarge);
      break;
    case SCREE_SHAPE_EXTRUSION:
      changed |= drag("low", &node->extrusion.low, 0.02, -kLarge, kLarge);
      changed |= drag("high", &node->extrusion.high, 0.02, -kLarge, kLarge);
      node->extrusion.high = std::max(node->extrusion.high, node->extrusion.low + kSmall);
      changed |= point_widgets(node);
      break;
    case SCREE_SHAPE_TUBE:
      changed |= ImGui::Checkbox("closed", &node->tube.closed);
      changed |= drag("half height", &node->tube.half_height, 0.01, 0, kLarge);
      if (node->tube.subdivisions == 0) node->tube.subdivisions = 8;
      changed |= count_widget("pieces", &node->tube.subdivisions, 1, 32);
      changed |= point_widgets(node);
      break;
    case SCREE_SHAPE_BLOBS: changed |= point_widgets(node); break;
    case SCREE_SHAPE_PATTERN: changed |= pattern_widgets(node); break;
    case SCREE_SHAPE_NOISE: {
      static const uint32_t step = 1;
      changed |= drag("amplitude", &node->noise.amplitude, 0.005, kSmall, kLarge);
      changed |= drag("wavelength", &node->noise.wavelength, 0.02, kSmall, kLarge);
      changed |= count_widget("octaves", &node->noise.octaves, 1, 8);
      changed |= ImGui::InputScalar("noise seed", ImGuiDataType_U32, &node->noise.seed, &step);
      break;
    }
    case SCREE_SHAPE_SMOOTH_UNION: changed |= drag("blend", &node->group.blend, 0.01, kSmall, kLarge); break;
    default: break;
  }
  return changed;
}

void tree(editor* e, scene_node* node, int depth, int* number) {
  ImGui::PushID((*number)++);
  ImGui::Indent(static_cast<float>(depth) * 12.0f + 0.01f);
  std::string label = scene_kind_name(node->kind);
  if (node->name[0] != 0) label = std::string(node->name) + "  (" + label + ")";
  if (ImGui::Selectable(label.c_str(), e->node == node)) e->node = node;
  ImGui::Unindent(static_cast<float>(depth) * 12.0f + 0.01f);
  ImGui::PopID();
  for (uint32_t i = 0; i < node->child_count; ++i) tree(e, node->children[i], depth + 1, number);
}

void pack_widgets(panel* p, const panel_view* v, scene_field* field, bool* changed) {
  if (ImGui::GetTime() - p->packs_read > 2 || p->packs_read <= 0) {
    read_packs(p, v->packs);
    p->packs_read = ImGui::GetTime();
  }
  if (ImGui::BeginCombo("pack", field->pack)) {
    for (const std::string& name : p->packs)
      if (ImGui::Selectable(name.c_str(), name == field->pack) && name.size() < sizeof field->pack && name != field->pack) {
        std::memcpy(field->pack, name.c_str(), name.size() + 1);
        *changed = true;
      }
    if (p->packs.empty()) ImGui::TextDisabled("no *.scree in %s", v->packs);
    ImGui::EndCombo();
  }
}

// Filters: those from files can be changed and taken away; one by altitude can be added.
bool filter_widgets(scene_field* field) {
  bool changed = false;
  if (!ImGui::TreeNode("filters")) return false;
  for (uint32_t i = 0; i < field->filter_count; ++i) {
    scene_filter* filter = &field->filters[i];
    ImGui::PushID(static_cast<int>(i));
    ImGui::Text("%s %s", scene_filter_name(filter->kind), filter->map.file);
    if (filter->kind != SCREE_FILTER_MASK) {
      const bool slope = filter->kind == SCREE_FILTER_SLOPE;
      const double low = slope ? 0 : -kFar, high = slope ? 90 : kFar, speed = slope ? 0.2 : 0.02;
      changed |= drag("from", &filter->from, speed, low, filter->to, "%.2f");
      changed |= drag("to", &filter->to, speed, filter->from, high, "%.2f");
      changed |= drag("fade", &filter->fade, speed, 0, kNear, "%.2f");
    }
    if (filter->kind != SCREE_FILTER_ALTITUDE) changed |= drag3("centre", filter->position, 0.05, kFar);
    changed |= ImGui::Checkbox("inverted", &filter->inverted);
    ImGui::SameLine();
    const bool gone = ImGui::SmallButton("remove");
    ImGui::PopID();
    if (gone) {
      scene_remove_filter(field, i);
      changed = true;
      break;
    }
  }
  if (ImGui::SmallButton("by altitude")) {
    scene_filter* filter = scene_add_filter(field, SCREE_FILTER_ALTITUDE);
    if (filter != nullptr) filter->to = 100;
    changed |= filter != nullptr;
  }
  ImGui::TreePop();
  return changed;
}

// What only a scatter has.
bool scatter_widgets(scene_scatter* scatter) {
  bool changed = drag("spacing", &scatter->spacing, 0.01, 0.05, kLarge, "%.2f m");
  changed |= drag("smallest", &scatter->scale[0], 0.005, 0.01, scatter->scale[1]);
  changed |= drag("largest", &scatter->scale[1], 0.005, scatter->scale[0], 100);
  changed |= drag("steepest", &scatter->max_slope, 0.2, 1, 80, "%.0f degrees");
  if (scatter->has_ages) {
    ImGui::TextDisabled("ages by %s", scatter->ages.map.file);
    changed |= ImGui::Checkbox("black is old", &scatter->ages.inverted);
  }
  return changed;
}

// Which of its times a cliff is at: all of its parts go there together.
void cliff_time_widget(panel* p, panel_view* v, const scene_field* field) {
  if (v->times < 2) return;
  uint32_t time = field->cliff.time;
  if (time_widget(&time, v->times)) p->edited |= edit_cliff_time(v->edit, time);
  tooltip(
      "Moves every part of this cliff: the fields of this pack at this time, origin, turn and size, and the mesh shapes of "
      "supports that are of this pack at this time and stand nearest to this cliff.");
}

// What a field shows of its cliff, and where it stands.
bool cliff_widgets(scene_field* field) {
  static const char* const words[] = {"all", "standing", "blocks"};
  static_assert(SCREE_CLIFF_STANDING == 1 && SCREE_CLIFF_BLOCKS == 2, "the words are in the order of the values");
  int what = static_cast<int>(field->cliff.what % 3);
  bool changed = ImGui::Combo("what", &what, words, 3);
  if (changed) field->cliff.what = static_cast<uint32_t>(what);
  tooltip("What this field shows of the cliff: what stands, the blocks that fell, or both.");
  static const char* const axes[] = {"x", "y", "z"};
  for (int a = 0; a < 3; ++a) changed |= drag(axes[a], &field->origin[a], 0.05, -kFar, kFar, "%.2f m");
  changed |= drag("turn", &field->cliff.turn, 0.5, -360, 360, "%.0f degrees");
  changed |= drag("size", &field->cliff.scale, 0.005, 0.01, 100);
  return changed;
}

void field_widgets(panel* p, panel_view* v) {
  editor* e = v->edit;
  scene_model* scene = e->scene;
  for (uint32_t i = 0; i < scene->field_count; ++i) {
    char label[SCENE_NAME_SIZE + SCENE_FILE_SIZE + 64];
    const scene_field* f = &scene->fields[i];
    std::snprintf(label, sizeof label, "%s  %u %s of %s##%u", f->name[0] != 0 ? f->name : "field", v->stone_counts[i],
                  f->is_scatter ? "models"
                  : f->is_cliff ? "pieces"
                                : "stones",
                  f->scatter.model_count > 0 ? f->scatter.models[0] : f->pack, i);
    if (ImGui::Selectable(label, e->field == i) && e->field != i) {
      e->field = i;
      e->node = nullptr;
    }
  }
  if (e->field >= scene->field_count) return;
  scene_field* field = &scene->fields[e->field];
  bool changed = false;
  if (field->is_scatter && field->scatter.model_count > 0)
    for (uint32_t i = 0; i < field->scatter.model_count; ++i) ImGui::TextDisabled("%s", field->scatter.models[i]);
  else
    pack_widgets(p, v, field, &changed);
  static const uint64_t step = 1, seed_most = UINT64_C(1) << 53;
  if (ImGui::InputScalar("seed", ImGuiDataType_U64, &field->seed, &step)) {
    field->seed = std::min(field->seed, seed_most);
    changed = true;
  }
  if (field->is_scatter)
    changed |= scatter_widgets(&field->scatter);
  else if (field->is_cliff) {
    cliff_time_widget(p, v, field);
    changed |= cliff_widgets(field);
  } else
    changed |= drag("cell size", &field->cell_size, 0.002, 0.01, 1000, "%.3f m");
  if (changed) {
    edit_touch(e, SCENE_CHANGED_PACK);
    p->edited = true;
  }
  bool shape = false;
  if (!field->is_scatter && !field->is_cliff) {
    shape |= drag("threshold", &field->threshold, 0.002, 0.01, 0.99);
    shape |= ImGui::Checkbox("leave out what nobody sees", &field->shell);
  }
  if (!field->is_cliff) {
    shape |= drag("density", &field->density, 0.002, 0.001, 1);
    shape |= filter_widgets(field);
  }
  if (shape) {
    edit_touch(e, SCENE_CHANGED_RULES);
    p->edited = true;
  }
  if (!ImGui::TreeNode("colours")) return;
  bool painted = false;
  for (uint32_t i = 0; i < field->palette.colour_count; ++i) {
    ImGui::PushID(static_cast<int>(i));
    painted |= ImGui::ColorEdit3("##base", field->palette.colours[i]);
    ImGui::PopID();
  }
  if (field->palette.colour_count < SCENE_PALETTE_MAX && ImGui::SmallButton("one more")) {
    std::memcpy(field->palette.colours[field->palette.colour_count], field->palette.colours[0], sizeof field->palette.colours[0]);
    ++field->palette.colour_count;
    painted = true;
  }
  ImGui::SameLine();
  if (field->palette.colour_count > 1 && ImGui::SmallButton("one less")) {
    --field->palette.colour_count;
    painted = true;
  }
  painted |= drag("variation", &field->palette.variation, 0.005, 0, 1);
  if (painted) {
    edit_touch(e, SCENE_CHANGED_PALETTE);
    p->edited = true;
  }
  ImGui::TreePop();
}

void support_widgets(panel* p, panel_view* v) {
  editor* e = v->edit;
  if (e->field >= e->scene->field_count) return;
  if (e->scene->fields[e->field].is_cliff) {
    ImGui::TextDisabled("a cliff stands where its origin is");
    return;
  }
  scene_node* root = e->scene->fields[e->field].support;
  int number = 0;
  if (root != nullptr) tree(e, root, 0, &number);
  ImGui::TextDisabled("add");
  static const struct {
    const char* name;
    scree_shape_kind kind;
  } kinds[] = {{"sphere", SCREE_SHAPE_SPHERE},   {"box", SCREE_SHAPE_BOX},
               {"capsule", SCREE_SHAPE_CAPSULE}, {"cylinder", SCREE_SHAPE_CYLINDER},
               {"cone", SCREE_SHAPE_CONE},       {"ellipsoid", SCREE_SHAPE_ELLIPSOID},
               {"torus", SCREE_SHAPE_TORUS},     {"extrusion", SCREE_SHAPE_EXTRUSION},
               {"tube", SCREE_SHAPE_TUBE},       {"blobs", SCREE_SHAPE_BLOBS},
               {"pattern", SCREE_SHAPE_PATTERN}};
  for (const auto& kind : kinds) {
    // As many to a line as fit.
    ImGui::SameLine();
    if (ImGui::GetContentRegionAvail().x < ImGui::CalcTextSize(kind.name).x + 2 * ImGui::GetStyle().FramePadding.x)
      ImGui::NewLine();
    if (ImGui::SmallButton(kind.name)) p->edited |= edit_add(e, kind.kind, v->place, v->size);
  }
  if (e->node == nullptr) {
    ImGui::TextDisabled("select a support here or in the picture");
    return;
  }
  if (ImGui::Button("Duplicate")) p->edited |= edit_duplicate(e);
  ImGui::SameLine();
  if (ImGui::Button("Roughen")) p->edited |= edit_wrap(e, SCREE_SHAPE_NOISE);
  ImGui::SameLine();
  if (ImGui::Button("Cut flat")) p->edited |= edit_wrap(e, SCREE_SHAPE_HALF_SPACE);
  ImGui::SameLine();
  if (ImGui::Button("Delete") && edit_delete(e)) {
    p->edited = true;
    return;
  }
  scene_node* node = e->node;
  bool changed = false;
  if (ImGui::InputText("name", node->name, sizeof node->name)) {
    e->unsaved = true;
    p->edited = true;
  }
  changed |= drag3("position", node->position, 0.02, kFar);
  changed |= drag3("rotation", node->rotation, 0.5, kTurns, "%.1f");
  changed |= drag("scale", &node->scale, 0.005, kSmall, 1000);
  changed |= shape_widgets(node, v->mesh_times);
  if (changed) {
    edit_touch(e, SCENE_CHANGED_SUPPORT);
    p->edited = true;
  }
}

void light_widgets(panel* p, panel_view* v) {
  scene_model* scene = v->edit->scene;
  double* d = scene->sun.direction;
  const double degrees = 57.29577951308232, flat = std::hypot(d[0], d[2]);
  float azimuth = static_cast<float>(std::atan2(d[0], d[2]) * degrees),
        elevation = static_cast<float>(std::atan2(d[1], flat) * degrees);
  bool turned = ImGui::SliderFloat("sun azimuth", &azimuth, -180, 180, "%.0f");
  turned |= ImGui::SliderFloat("sun height", &elevation, 3, 89, "%.0f");
  if (turned) {
    const double a = static_cast<double>(azimuth) / degrees, h = static_cast<double>(elevation) / degrees;
    d[0] = std::sin(a) * std::cos(h);
    d[1] = std::sin(h);
    d[2] = std::cos(a) * std::cos(h);
  }
  bool changed = turned;
  changed |= ImGui::ColorEdit3("sun", scene->sun.colour);
  changed |= ImGui::ColorEdit3("sky", scene->sky);
  changed |= ImGui::ColorEdit3("ground", scene->ground.colour);
  changed |= ImGui::Checkbox("sand", &scene->ground.sand);
  if (scene->ground.kind == SCENE_GROUND_PLANE) changed |= drag("ground height", &scene->ground.height, 0.02, -kLarge, kLarge);
  if (scene->ground.kind == SCENE_GROUND_TERRAIN && scene->ground.water) {
    changed |= ImGui::ColorEdit3("water", scene->ground.water_colour);
    changed |= drag("water height", &scene->ground.water_height, 0.02, -kFar, kFar);
  }
  if (changed) v->edit->unsaved = p->edited = true;
}

void main_window(panel* p, panel_view* v, panel_wishes* wishes) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  const float width = 340;
  ImGui::SetNextWindowPos(ImVec2(viewport->WorkPos.x + viewport->WorkSize.x - width - 10, viewport->WorkPos.y + 10),
                          ImGuiCond_Once);
  ImGui::SetNextWindowSize(ImVec2(width, viewport->WorkSize.y - 20), ImGuiCond_Once);
  char title[SCENE_NAME_SIZE + 32];
  std::snprintf(title, sizeof title, "%s%s###scene", v->edit->scene->name[0] != 0 ? v->edit->scene->name : "Scene",
                v->edit->unsaved ? " *" : "");
  if (ImGui::Begin(title, &v->panel)) {
    ImGui::PushItemWidth(-110);
    if (ImGui::Button("Save")) wishes->save = true;
    ImGui::SameLine();
    if (ImGui::Button("Undo")) wishes->undo = true;
    ImGui::SameLine();
    if (ImGui::Button("Redo")) wishes->redo = true;
    ImGui::SameLine();
    if (ImGui::Button("Picture")) wishes->picture = true;
    ImGui::SameLine();
    if (ImGui::Button("Home")) wishes->home = true;
    int colour = v->colour;
    static const char* const words[] = {"stone", "level of detail", "tile code"};
    if (ImGui::Combo("colour", &colour, words, 3)) v->colour = static_cast<render_colour>(colour);
    ImGui::Checkbox("wireframe", &v->wireframe);
    ImGui::SameLine();
    ImGui::Checkbox("fly", &v->flying);
    ImGui::SameLine();
    ImGui::Checkbox("figures", &v->figures);
    if (ImGui::CollapsingHeader("Fields", ImGuiTreeNodeFlags_DefaultOpen)) field_widgets(p, v);
    if (ImGui::CollapsingHeader("Supports", ImGuiTreeNodeFlags_DefaultOpen)) support_widgets(p, v);
    if (ImGui::CollapsingHeader("Light and ground")) light_widgets(p, v);
    ImGui::PopItemWidth();
  }
  ImGui::End();
}

void figures_window(const panel_view* v) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos(ImVec2(viewport->WorkPos.x + 10, viewport->WorkPos.y + 10));
  ImGui::SetNextWindowBgAlpha(0.62f);
  if (ImGui::Begin("##figures", nullptr, kPlain)) {
    const render_stats& s = v->stats;
    ImGui::Text("%u stones, %u in view", s.stones, s.stones_drawn);
    ImGui::Text("%.2f M triangles, %.2f M for shadows", static_cast<double>(s.triangles) * 1e-6,
                static_cast<double>(s.shadow_triangles) * 1e-6);
    ImGui::Text("%u meshes drawn, %u held (%.1f MB)%s", s.draws, s.meshes, static_cast<double>(s.mesh_bytes) * 1e-6,
                s.indirect ? "" : ", OpenGL 3.3 path");
    if (s.meshes_missing > 0) ImGui::Text("%u meshes to decode", s.meshes_missing);
    ImGui::Text("frame %.1f ms, query %.1f ms, %u samples", v->frame_seconds * 1e3, v->query_seconds * 1e3, s.samples);
    ImGui::TextDisabled("F1 help, Tab panel");
  }
  ImGui::End();
}

}  // namespace

panel* panel_create(GLFWwindow* window) {
  panel* p = new (std::nothrow) panel();
  if (p != nullptr) p->context = panel_frame_create(window);
  return p;
}

void panel_destroy(panel* p) {
  if (p == nullptr) return;
  panel_frame_destroy(p->context);
  delete p;
}

bool panel_wants_pointer(const panel*) {
  return ImGui::GetIO().WantCaptureMouse;
}
bool panel_wants_keys(const panel*) {
  return ImGui::GetIO().WantTextInput;
}

void panel_draw(panel* p, panel_view* view, panel_wishes* wishes) {
  *wishes = {};
  panel_frame_begin();
  if (view->panel) main_window(p, view, wishes);
  if (view->figures) figures_window(view);
  if (view->help) panel_keys(view_keys, &view->help);
  panel_message(view->message, view->message_is_error);
  if (p->edited && !ImGui::IsAnyItemActive()) {
    edit_commit(view->edit);
    p->edited = false;
  }
  panel_frame_end();
}
