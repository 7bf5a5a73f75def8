#include "weather_panel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>

#include "panel_frame.h"
#include "weather_graph.h"

struct weather_panel {
  ImGuiContext* context;
  uint32_t point, segment;   // selected
  bool point_held;           // by the pointer
  uint32_t border_held;      // a segment whose lower border is held, NONE
  ImVec2 press;              // where it was pressed
  bool moved;                // away from there: what is only clicked stays where it is
  double grab[2];            // from the pointer to what it holds: altitude, logarithm of durability
  weather_range held_range;  // that of the drag: a scale that moves under the pointer would run away
  double popup_altitude;
  ImVec2 graph_min, graph_max;  // where it was drawn; no width = it was not
};

namespace {

const float kWidth = 372, kGraphHeight = 250, kBubbles = 78, kPointRadius = 5, kReach = 9, kMargin = 8;

ImU32 colour_of(const weather_range& range, double durability, int alpha = 255) {
  uint8_t rgb[3];
  weather_durability_colour(&range, durability, rgb);
  return IM_COL32(rgb[0], rgb[1], rgb[2], alpha);
}

bool drag(const char* label, double* value, double low, double high, const char* format, bool logarithmic = false) {
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | (logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  return ImGui::SliderScalar(label, ImGuiDataType_Double, value, &low, &high, format, flags);
}

// Where altitudes and durabilities are on the screen.
struct Graph {
  ImVec2 min, max;
  weather_range range;
  float y(double altitude) const { return max.y - static_cast<float>(altitude) * (max.y - min.y); }
  double altitude(float at) const { return std::clamp(static_cast<double>((max.y - at) / (max.y - min.y)), 0.0, 1.0); }
  float x(double durability) const {
    const double t = std::log(std::max(durability, 1e-9) / range.low) / std::log(range.high / range.low);
    return min.x + static_cast<float>(std::clamp(t, 0.0, 1.0)) * (max.x - min.x);
  }
  double durability(float at) const {
    const double t = std::clamp(static_cast<double>((at - min.x) / (max.x - min.x)), 0.0, 1.0);
    return range.low * std::pow(range.high / range.low, t);
  }
};

// How the noise of a segment looks along the altitude, -1..1: not what the rock has, but as long and as high.
double wiggle(const scree_durability_point& p, double altitude, uint32_t height) {
  const double period = (p.noise_period > 0 ? p.noise_period : 16) / (p.noise_squash > 0 ? p.noise_squash : 1);
  const double turns = 6.283185307179586 * altitude * height / period;
  return 0.62 * std::sin(turns) + 0.38 * std::sin(2.3 * turns + 1.7);
}

void draw_grid(ImDrawList* list, const Graph& g) {
  list->AddRectFilled(ImVec2(g.min.x, g.min.y - kMargin), ImVec2(g.max.x, g.max.y + kMargin), IM_COL32(20, 22, 24, 255), 4);
  for (int i = 1; i < 4; ++i)
    list->AddLine(ImVec2(g.min.x, g.y(0.25 * i)), ImVec2(g.max.x, g.y(0.25 * i)), IM_COL32(255, 255, 255, 18));
  for (double decade = g.range.low; decade <= g.range.high * 1.001; decade *= 10) {
    list->AddLine(ImVec2(g.x(decade), g.min.y), ImVec2(g.x(decade), g.max.y), IM_COL32(255, 255, 255, 40));
    char text[24];
    std::snprintf(text, sizeof text, "%g", decade);
    const float width = ImGui::CalcTextSize(text).x;
    list->AddText(ImVec2(std::clamp(g.x(decade) - 0.5f * width, g.min.x + 2, g.max.x - width - 2), g.max.y + kMargin + 1),
                  IM_COL32(170, 170, 165, 255), text);
  }
}

void draw_line(ImDrawList* list, const Graph& g, const scree_hoodoo_rules& rules, uint32_t height, uint32_t hot) {
  const int PIECES = 160;
  ImVec2 before;
  for (int i = 0; i <= PIECES; ++i) {
    const double altitude = static_cast<double>(i) / PIECES;
    const uint32_t below = weather_graph_point_below(&rules, altitude);
    const scree_durability_point& p = rules.durability[below];
    const double durability = weather_graph_durability(&rules, altitude);
    const double least = std::max(durability * (1 - p.noise_amplitude), durability / 16);
    const float y = g.y(altitude);
    if (p.noise_amplitude > 0 && i < PIECES)
      list->AddRectFilled(ImVec2(g.x(least), std::round(g.y(altitude + 1.0 / PIECES))),
                          ImVec2(g.x(durability * (1 + p.noise_amplitude)), std::round(y)), colour_of(g.range, durability, 50));
    const double noisy = std::max(durability * (1 + p.noise_amplitude * wiggle(p, altitude, height)), durability / 16);
    const ImVec2 here(g.x(noisy), y);
    if (i > 0) list->AddLine(before, here, colour_of(g.range, noisy), below == hot ? 3.6f : 2.4f);
    before = here;
  }
  for (uint32_t i = 0; i + 1 < rules.durability_count; ++i) {
    const scree_durability_point &a = rules.durability[i], &b = rules.durability[i + 1];
    list->AddLine(ImVec2(g.x(a.durability), g.y(a.altitude)), ImVec2(g.x(b.durability), g.y(b.altitude)),
                  IM_COL32(255, 255, 255, 46));
  }
}

uint32_t point_at(const Graph& g, const scree_hoodoo_rules& rules, ImVec2 at) {
  uint32_t best = WEATHER_GRAPH_NONE;
  float nearest = kReach;
  for (uint32_t i = 0; i < rules.durability_count; ++i) {
    const float d = std::hypot(g.x(rules.durability[i].durability) - at.x, g.y(rules.durability[i].altitude) - at.y);
    if (d < nearest) {
      nearest = d;
      best = i;
    }
  }
  return best;
}

bool noise_widgets(scree_durability_point* p) {
  bool changed = drag("amplitude", &p->noise_amplitude, 0, 4, "%.2f");
  if (!(p->noise_period >= 1)) p->noise_period = 16;
  if (!(p->noise_squash >= 0.1)) p->noise_squash = 1;
  changed |= drag("period", &p->noise_period, 1, 256, "%.1f voxels", true);
  return drag("squash", &p->noise_squash, 0.1, 100, "%.2f", true) || changed;
}

bool point_widgets(weather_panel* p, scree_hoodoo_rules* rules) {
  scree_durability_point* at = &rules->durability[p->point];
  double altitude = at->altitude, durability = at->durability;
  bool changed = drag("altitude", &altitude, 0, 1, "%.3f");
  changed |= drag("durability", &durability, WEATHER_DURABILITY_LEAST, 1e3, "%.3f", true);
  if (changed) weather_graph_move_point(rules, p->point, altitude, durability);
  return changed;
}

bool remove_point(weather_panel* p, scree_hoodoo_rules* rules) {
  const bool gone = weather_graph_remove_point(rules, p->point);
  p->point = std::min(p->point, rules->durability_count - 1);
  return gone;
}

// Has the pointer moved since it was pressed? Also asked in the frame that lets go, which may be the one after the press.
bool moved(weather_panel* p) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  p->moved = p->moved || std::hypot(at.x - p->press.x, at.y - p->press.y) > 2;
  return p->moved;
}

void press(weather_panel* p) {
  p->press = ImGui::GetIO().MousePos;
  p->moved = false;
}

// What the pointer does in the durability graph.
bool durability_pointer(weather_panel* p, const Graph& g, scree_hoodoo_rules* rules) {
  bool changed = false;
  const ImVec2 at = ImGui::GetIO().MousePos;
  if (ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    uint32_t point = point_at(g, *rules, at);
    const double altitude = g.altitude(at.y);
    press(p);
    if (point == WEATHER_GRAPH_NONE && std::fabs(g.x(weather_graph_durability(rules, altitude)) - at.x) < 1.5f * kReach) {
      point = weather_graph_add_point(rules, altitude);
      changed = point != WEATHER_GRAPH_NONE;
    }
    p->point_held = point != WEATHER_GRAPH_NONE;
    p->held_range = g.range;
    p->point = p->point_held ? point : weather_graph_point_below(rules, altitude);
    if (p->point_held) {
      p->grab[0] = rules->durability[point].altitude - altitude;
      p->grab[1] = std::log(rules->durability[point].durability / g.durability(at.x));
    }
  }
  if (p->point_held && moved(p)) {
    const scree_durability_point before = rules->durability[p->point];
    const double raw = static_cast<double>((g.max.y - at.y) / (g.max.y - g.min.y));
    weather_graph_move_point(rules, p->point, raw + p->grab[0], g.durability(at.x) * std::exp(p->grab[1]));
    const scree_durability_point& now = rules->durability[p->point];
    changed |= before.altitude != now.altitude || before.durability != now.durability;
  }
  if (!ImGui::IsItemActive()) p->point_held = false;
  if (ImGui::IsItemHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
    const uint32_t point = point_at(g, *rules, at);
    p->point = point != WEATHER_GRAPH_NONE ? point : weather_graph_point_below(rules, g.altitude(at.y));
    ImGui::OpenPopup(point != WEATHER_GRAPH_NONE ? "##point popup" : "##noise popup");
  }
  return changed;
}

bool durability_popups(weather_panel* p, scree_hoodoo_rules* rules) {
  bool changed = false;
  if (ImGui::BeginPopup("##point popup")) {
    ImGui::PushItemWidth(150);
    changed |= point_widgets(p, rules);
    ImGui::PopItemWidth();
    if (ImGui::MenuItem("remove", "Delete", false, rules->durability_count > 1)) changed |= remove_point(p, rules);
    ImGui::EndPopup();
  }
  if (ImGui::BeginPopup("##noise popup")) {
    ImGui::TextDisabled("noise of this segment");
    ImGui::PushItemWidth(150);
    changed |= noise_widgets(&rules->durability[p->point]);
    ImGui::PopItemWidth();
    ImGui::EndPopup();
  }
  return changed;
}

bool durability_graph(weather_panel* p, weather_panel_view* v, ImVec2 size) {
  scree_hoodoo_rules* rules = &v->rules;
  p->point = std::min(p->point, rules->durability_count - 1);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  Graph g = {ImVec2(corner.x, corner.y + kMargin), ImVec2(corner.x + size.x, corner.y + size.y - kMargin),
             p->point_held ? p->held_range : weather_range_of(rules->durability, rules->durability_count)};
  ImGui::InvisibleButton("##durability graph", size, ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  p->graph_min = g.min;
  p->graph_max = g.max;
  bool changed = durability_pointer(p, g, rules);
  if (v->remove_point && !p->point_held) changed |= remove_point(p, rules);
  v->remove_point = false;
  const bool hovered = ImGui::IsItemHovered();
  ImDrawList* list = ImGui::GetWindowDrawList();
  draw_grid(list, g);
  list->PushClipRect(corner, ImVec2(corner.x + size.x, corner.y + size.y), true);
  draw_line(list, g, *rules, v->recipe->size[1], p->point);
  const uint32_t hot = hovered ? point_at(g, *rules, ImGui::GetIO().MousePos) : WEATHER_GRAPH_NONE;
  for (uint32_t i = 0; i < rules->durability_count; ++i) {
    const scree_durability_point& at = rules->durability[i];
    const ImVec2 place(g.x(at.durability), g.y(at.altitude));
    const bool chosen = i == p->point;
    list->AddCircleFilled(place, i == hot || chosen ? kPointRadius + 1 : kPointRadius, colour_of(g.range, at.durability));
    list->AddCircle(place, i == hot || chosen ? kPointRadius + 1 : kPointRadius, chosen ? IM_COL32_WHITE : IM_COL32(0, 0, 0, 200),
                    0, chosen ? 2.0f : 1.0f);
  }
  list->PopClipRect();
  return durability_popups(p, rules) || changed;
}

// --- Bubbles ---

const char* const kBubbleKinds[] = {"sphere", "ellipsoid", "gumdrop", "disc"};

void draw_bubble(ImDrawList* list, const scree_bubble& bubble, ImVec2 at, float voxel, ImU32 colour) {
  const float r = static_cast<float>(bubble.radius) * voxel;
  const float h = bubble.kind == SCREE_BUBBLE_ELLIPSOID ? static_cast<float>(bubble.height) * voxel
                  : bubble.kind == SCREE_BUBBLE_DISC    ? 1.5f * voxel
                                                        : r;
  if (bubble.kind == SCREE_BUBBLE_DISC) {
    list->AddRect(ImVec2(at.x - r, at.y - h), ImVec2(at.x + r, at.y + h), colour, 1, 0, 1.6f);
    return;
  }
  const int SIDES = 40;
  ImVec2 outline[SIDES];
  for (int i = 0; i < SIDES; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(SIDES);
    float y = std::sin(angle) * h;
    if (bubble.kind == SCREE_BUBBLE_GUMDROP) y = std::min(y, 0.5f * r);
    outline[i] = ImVec2(at.x + std::cos(angle) * r, at.y + y);
  }
  list->AddPolyline(outline, SIDES, colour, ImDrawFlags_Closed, 1.6f);
}

double segment_top(const scree_hoodoo_rules& rules, uint32_t segment) {
  return segment + 1 < rules.bubble_count ? rules.bubbles[segment + 1].altitude : 1;
}

double segment_bottom(const scree_hoodoo_rules& rules, uint32_t segment) {
  return segment > 0 ? rules.bubbles[segment].altitude : 0;
}

uint32_t border_at(const Graph& g, const scree_hoodoo_rules& rules, float y) {
  for (uint32_t i = 1; i < rules.bubble_count; ++i)
    if (std::fabs(g.y(rules.bubbles[i].altitude) - y) < 6) return i;
  return WEATHER_GRAPH_NONE;
}

bool bubble_pointer(weather_panel* p, const Graph& g, scree_hoodoo_rules* rules) {
  bool changed = false;
  const ImVec2 at = ImGui::GetIO().MousePos;
  if (ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    press(p);
    p->border_held = border_at(g, *rules, at.y);
    p->segment = p->border_held != WEATHER_GRAPH_NONE ? p->border_held : weather_graph_segment_at(rules, g.altitude(at.y));
    if (p->border_held != WEATHER_GRAPH_NONE) p->grab[0] = rules->bubbles[p->border_held].altitude - g.altitude(at.y);
  }
  if (p->border_held < rules->bubble_count && moved(p)) {
    const double before = rules->bubbles[p->border_held].altitude;
    weather_graph_move_border(rules, p->border_held, g.altitude(at.y) + p->grab[0]);
    changed = before != rules->bubbles[p->border_held].altitude;
  }
  if (!ImGui::IsItemActive()) p->border_held = WEATHER_GRAPH_NONE;
  if (ImGui::IsItemHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
    p->popup_altitude = g.altitude(at.y);
    p->segment = weather_graph_segment_at(rules, p->popup_altitude);
    ImGui::OpenPopup("##bubble popup");
  }
  if (ImGui::IsItemHovered() && (p->border_held != WEATHER_GRAPH_NONE || border_at(g, *rules, at.y) != WEATHER_GRAPH_NONE))
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeNS);
  if (ImGui::BeginPopup("##bubble popup")) {
    if (ImGui::MenuItem("cut in two here", nullptr, false, rules->bubble_count < SCREE_HOODOO_SEGMENTS)) {
      const uint32_t upper = weather_graph_split(rules, p->popup_altitude);
      changed |= upper != WEATHER_GRAPH_NONE;
      if (upper != WEATHER_GRAPH_NONE) p->segment = upper;
    }
    if (ImGui::MenuItem("remove", nullptr, false, rules->bubble_count > 1))
      changed |= weather_graph_remove_segment(rules, p->segment);
    ImGui::EndPopup();
  }
  p->segment = std::min(p->segment, rules->bubble_count - 1);
  return changed;
}

bool bubble_graph(weather_panel* p, weather_panel_view* v, ImVec2 size) {
  scree_hoodoo_rules* rules = &v->rules;
  p->segment = std::min(p->segment, rules->bubble_count - 1);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const Graph g = {ImVec2(corner.x, corner.y + kMargin), ImVec2(corner.x + size.x, corner.y + size.y - kMargin), {1, 10}};
  ImGui::InvisibleButton("##bubble graph", size, ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  const bool changed = bubble_pointer(p, g, rules);
  ImDrawList* list = ImGui::GetWindowDrawList();
  for (uint32_t i = 0; i < rules->bubble_count; ++i) {
    const scree_bubble_segment& s = rules->bubbles[i];
    const ImVec2 top(g.min.x, g.y(segment_top(*rules, i))), bottom(g.max.x, g.y(segment_bottom(*rules, i)));
    list->AddRectFilled(top, bottom,
                        i == p->segment ? IM_COL32(64, 52, 34, 255)
                        : i % 2         ? IM_COL32(30, 34, 38, 255)
                                        : IM_COL32(22, 25, 28, 255),
                        4);
    list->PushClipRect(top, bottom, true);
    const float middle = 0.5f * (top.y + bottom.y), voxel = 0.5f * size.x / 12.5f;
    for (uint32_t k = 0; k < s.bubble_count; ++k)
      draw_bubble(list, s.bubbles[k], ImVec2(0.5f * (g.min.x + g.max.x), middle), voxel,
                  IM_COL32(230, 190, 110, 255 - 45 * static_cast<int>(k)));
    list->PopClipRect();
    if (i > 0) list->AddLine(ImVec2(g.min.x, bottom.y), ImVec2(g.max.x, bottom.y), IM_COL32(230, 230, 225, 200), 2);
  }
  return changed;
}

bool segment_widgets(weather_panel* p, scree_hoodoo_rules* rules) {
  scree_bubble_segment* s = &rules->bubbles[p->segment];
  bool changed = false;
  for (uint32_t k = 0; k < s->bubble_count; ++k) {
    scree_bubble* bubble = &s->bubbles[k];
    ImGui::PushID(static_cast<int>(k));
    int kind = bubble->kind;
    if (ImGui::Combo("bubble", &kind, kBubbleKinds, 4)) {
      bubble->kind = static_cast<scree_bubble_kind>(kind);
      if (kind == SCREE_BUBBLE_ELLIPSOID && !(bubble->height >= 1)) bubble->height = bubble->radius;
      changed = true;
    }
    changed |= drag("radius", &bubble->radius, 1, 12, "%.1f voxels");
    if (bubble->kind == SCREE_BUBBLE_ELLIPSOID) changed |= drag("height", &bubble->height, 1, 12, "%.1f voxels");
    ImGui::PopID();
  }
  if (s->bubble_count < 4 && ImGui::SmallButton("mix in one more")) {
    s->bubbles[s->bubble_count] = s->bubbles[s->bubble_count - 1];
    ++s->bubble_count;
    if (!(s->noise_period >= 1)) s->noise_period = 16;
    changed = true;
  }
  if (s->bubble_count > 1) {
    ImGui::SameLine();
    if (ImGui::SmallButton("one less")) {
      --s->bubble_count;
      changed = true;
    }
    changed |= drag("period of the mixture", &s->noise_period, 1, 256, "%.1f voxels", true);
  }
  return changed;
}

// --- Other rules ---

bool curve_widgets(const char* name, scree_curve* curve) {
  static const char* const kinds[] = {"none", "linear: c", "cubic: 3 c^3", "quartic: 3 c^4", "saturating"};
  ImGui::PushID(name);
  int kind = curve->kind;
  bool changed = ImGui::Combo(name, &kind, kinds, 5);
  if (changed) {
    curve->kind = static_cast<scree_curve_kind>(kind);
    if (!(curve->gain > 0)) curve->gain = 1;
    if (!(curve->saturation >= 1e-3)) curve->saturation = 0.2;
    if (curve->power < 1) curve->power = 1;
  }
  if (curve->kind != SCREE_CURVE_NONE) changed |= drag("gain", &curve->gain, 0, 20, "%.2f", true);
  if (curve->kind == SCREE_CURVE_SATURATING) {
    changed |= drag("threshold", &curve->threshold, -1, 1, "%.3f");
    changed |= drag("saturation", &curve->saturation, 1e-3, 2, "%.3f", true);
    const uint32_t low = 1, high = 4;
    changed |= ImGui::SliderScalar("power", ImGuiDataType_U32, &curve->power, &low, &high, "%u", ImGuiSliderFlags_AlwaysClamp);
  }
  ImGui::PopID();
  return changed;
}

bool rule_widgets(scree_hoodoo_rules* rules) {
  static const char* const falls[] = {"stays in the air", "falls and is gone", "falls and crumbles"};
  bool changed = curve_widgets("spheroidal", &rules->spheroidal);
  changed |= curve_widgets("cavernous", &rules->cavernous);
  changed |= drag("exposure", &rules->exposure, 0, 2, "%.2f");
  changed |= drag("steps a voxel", &rules->steps_per_voxel, 1, 200, "%.1f", true);
  ImGui::TextDisabled("colluvium");
  changed |= drag("share", &rules->colluvium_share, 0, 1, "%.2f");
  changed |= drag("durability##colluvium", &rules->colluvium_durability, 1e-3, 100, "%.3f", true);
  double degrees = std::atan(rules->repose) * 57.29577951308232;
  if (drag("repose", &degrees, 3.6, 75.9, "%.1f degrees")) {
    rules->repose = std::clamp(std::tan(degrees / 57.29577951308232), 0.0625, 4.0);
    changed = true;
  }
  int fall = rules->rockfall;
  if (ImGui::Combo("what hangs", &fall, falls, 3)) {
    rules->rockfall = static_cast<scree_rockfall>(fall);
    changed = true;
  }
  return changed;
}

// --- Time ---

// A slider back in time, with ages above and changes of the rules below.
void timeline(const weather_panel_view* v, weather_panel_wishes* wishes) {
  const ImVec2 corner = ImGui::GetCursorScreenPos(), size(ImGui::GetContentRegionAvail().x, 26);
  const uint32_t step = static_cast<uint32_t>(v->stats.step), end = std::max(v->last, 1u);
  ImGui::InvisibleButton("##time", size);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float left = corner.x + 6, right = corner.x + size.x - 6, middle = corner.y + 13;
  const auto place = [&](uint32_t at) {
    return left + (right - left) * static_cast<float>(std::min(at, end)) / static_cast<float>(end);
  };
  list->AddRectFilled(ImVec2(left, middle - 3), ImVec2(right, middle + 3), IM_COL32(46, 48, 52, 255), 3);
  list->AddRectFilled(ImVec2(left, middle - 3), ImVec2(place(step), middle + 3), IM_COL32(150, 112, 52, 255), 3);
  for (uint32_t i = 0; i < v->age_count; ++i)
    if (v->age_steps[i] <= end) {
      const float x = place(v->age_steps[i]);
      list->AddTriangleFilled(ImVec2(x - 4, middle - 12), ImVec2(x + 4, middle - 12), ImVec2(x, middle - 4),
                              IM_COL32(240, 220, 170, 255));
    }
  for (uint32_t i = 0; i < v->recipe->phase_count; ++i)
    if (v->recipe->phases[i].share < 0 && v->recipe->phases[i].steps <= end) {
      const float x = place(v->recipe->phases[i].steps);
      list->AddTriangleFilled(ImVec2(x - 4, middle + 12), ImVec2(x, middle + 4), ImVec2(x + 4, middle + 12),
                              IM_COL32(130, 180, 220, 255));
    }
  list->AddCircleFilled(ImVec2(place(step), middle), 6, IM_COL32(245, 240, 230, 255));
  if (!ImGui::IsItemActive() && !ImGui::IsItemDeactivated()) return;
  const float t = std::clamp((ImGui::GetIO().MousePos.x - left) / (right - left), 0.0f, 1.0f);
  wishes->go_to = static_cast<uint32_t>(std::lround(t * static_cast<float>(end)));
  wishes->go = wishes->go_to != step;
}

void time_widgets(weather_panel_view* v, weather_panel_wishes* wishes) {
  if (ImGui::Button(v->playing ? "Pause" : "Play", ImVec2(64, 0))) v->playing = !v->playing;
  ImGui::SameLine();
  if (ImGui::Button("Step")) wishes->step = true;
  ImGui::SameLine();
  if (ImGui::Button("Restart")) wishes->restart = true;
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1);
  ImGui::SliderFloat("##speed", &v->steps_per_second, 0.5f, 60, "%.1f steps/s", ImGuiSliderFlags_Logarithmic);
  timeline(v, wishes);
  const scree_weather_stats& s = v->stats;
  const double share = s.start_rock > 0 ? 100.0 * static_cast<double>(s.rock) / static_cast<double>(s.start_rock) : 0;
  ImGui::Text("step %llu: %.1f %% left, %llu active", static_cast<unsigned long long>(s.step), share,
              static_cast<unsigned long long>(s.active));
  const uint32_t variants = v->recipe->variants;
  if (variants > 1) {
    int variant = static_cast<int>(v->variant);
    if (ImGui::SliderInt("variant", &variant, 0, static_cast<int>(variants) - 1, "%d", ImGuiSliderFlags_AlwaysClamp))
      wishes->variant = static_cast<uint32_t>(variant);
  }
}

void age_widgets(const weather_panel_view* v, weather_panel_wishes* wishes) {
  const bool shares = v->recipe->age_count > 0;
  if (ImGui::Button("Keep this age")) wishes->keep_age = true;
  for (uint32_t i = 0; i < v->age_count; ++i) {
    ImGui::PushID(static_cast<int>(i));
    char text[64];
    const bool reached = v->age_steps[i] != UINT32_MAX;
    if (shares)
      std::snprintf(text, sizeof text, "%.1f %%", 100 * v->recipe->ages[i]);
    else
      std::snprintf(text, sizeof text, "step %u", v->recipe->age_steps[i]);
    ImGui::BeginDisabled(!reached);
    if (ImGui::SmallButton(text)) {
      wishes->go = true;
      wishes->go_to = v->age_steps[i];
    }
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (reached)
      ImGui::TextDisabled("at step %u", v->age_steps[i]);
    else
      ImGui::TextDisabled("not yet");
    if (v->age_count > 1) {
      ImGui::SameLine(ImGui::GetContentRegionMax().x - 22);
      if (ImGui::SmallButton("x")) wishes->drop_age = i;
    }
    ImGui::PopID();
  }
}

void phase_widgets(const weather_panel_view* v, weather_panel_wishes* wishes) {
  static const char* const words[] = {"durability", "bubbles", "spheroidal", "cavernous",
                                      "exposure",   "steps",   "colluvium",  "rockfall"};
  for (uint32_t i = 0; i < v->recipe->phase_count; ++i) {
    const scree_hoodoo_phase& phase = v->recipe->phases[i];
    char text[160];
    int length = phase.share >= 0 ? std::snprintf(text, sizeof text, "from %.1f %% left:", 100 * phase.share)
                                  : std::snprintf(text, sizeof text, "from step %u:", phase.steps);
    for (int k = 0; k < 8; ++k)
      if ((phase.changes >> k & 1) != 0)
        length += std::snprintf(text + length, sizeof text - static_cast<size_t>(length), " %s", words[k]);
    ImGui::PushID(static_cast<int>(i));
    if (i < v->begun)
      ImGui::TextUnformatted(text);
    else
      ImGui::TextDisabled("%s", text);
    ImGui::SameLine(ImGui::GetContentRegionMax().x - 22);
    if (ImGui::SmallButton("x")) wishes->drop_phase = i;
    ImGui::PopID();
  }
  if (v->recipe->phase_count == 0) ImGui::TextDisabled("none: the rules hold from the start");
  if (ImGui::Button("Rules of now from the start")) wishes->flatten = true;
}

void main_window(weather_panel* p, weather_panel_view* v, weather_panel_wishes* wishes) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos(ImVec2(viewport->WorkPos.x + viewport->WorkSize.x - kWidth - 10, viewport->WorkPos.y + 10),
                          ImGuiCond_Once);
  ImGui::SetNextWindowSize(ImVec2(kWidth, viewport->WorkSize.y - 20), ImGuiCond_Once);
  char title[160];
  std::snprintf(title, sizeof title, "%s%s###weathering", v->recipe->name[0] != 0 ? v->recipe->name : "Hoodoo",
                v->unsaved ? " *" : "");
  if (ImGui::Begin(title, &v->panel)) {
    ImGui::PushItemWidth(-110);
    time_widgets(v, wishes);
    const float height = kGraphHeight;
    ImGui::TextDisabled("bubbles");
    ImGui::SameLine(kBubbles + 16);
    ImGui::TextDisabled("durability, soft to durable");
    bool changed = bubble_graph(p, v, ImVec2(kBubbles, height));
    ImGui::SameLine();
    changed |= durability_graph(p, v, ImVec2(ImGui::GetContentRegionAvail().x, height));
    ImGui::Dummy(ImVec2(1, ImGui::GetFontSize() * 0.8f));
    if (ImGui::CollapsingHeader("Selected", ImGuiTreeNodeFlags_DefaultOpen)) {
      ImGui::TextDisabled("point %u of %u", p->point + 1, v->rules.durability_count);
      changed |= point_widgets(p, &v->rules);
      changed |= noise_widgets(&v->rules.durability[p->point]);
      ImGui::TextDisabled("bubbles from %.2f to %.2f", segment_bottom(v->rules, p->segment), segment_top(v->rules, p->segment));
      changed |= segment_widgets(p, &v->rules);
    }
    if (ImGui::CollapsingHeader("Rules")) changed |= rule_widgets(&v->rules);
    if (ImGui::CollapsingHeader("Ages")) age_widgets(v, wishes);
    if (ImGui::CollapsingHeader("Changes on the way")) phase_widgets(v, wishes);
    if (ImGui::CollapsingHeader("Show", ImGuiTreeNodeFlags_DefaultOpen)) {
      static const char* const colours[] = {"stone", "durability", "curvature"};
      int colour = v->colour;
      if (ImGui::Combo("colour", &colour, colours, 3)) v->colour = static_cast<weather_colour>(colour);
      ImGui::Checkbox("wireframe", &v->wireframe);
      ImGui::SameLine();
      ImGui::Checkbox("figures", &v->figures);
      ImGui::SameLine();
      if (ImGui::SmallButton("home")) wishes->home = true;
    }
    if (ImGui::Button("Save recipe")) wishes->save = true;
    ImGui::SameLine();
    if (ImGui::Button("Export .glb")) wishes->export_glb = true;
    ImGui::SameLine();
    if (ImGui::Button("Picture")) wishes->picture = true;
    ImGui::PopItemWidth();
    wishes->rules = changed;
  }
  ImGui::End();
}

void figures_window(const weather_panel_view* v) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos(ImVec2(viewport->WorkPos.x + 10, viewport->WorkPos.y + 10));
  ImGui::SetNextWindowBgAlpha(0.62f);
  if (ImGui::Begin("##figures", nullptr, kPlain)) {
    const scree_weather_stats& s = v->stats;
    ImGui::Text("%llu voxels of rock, %llu of colluvium", static_cast<unsigned long long>(s.rock),
                static_cast<unsigned long long>(s.colluvium));
    ImGui::Text("%.1f k triangles, %.2f MB sent", v->triangles * 1e-3, static_cast<double>(v->sent) * 1e-6);
    ImGui::Text("step %.1f ms, surface %.1f ms, picture %.1f ms", v->step_seconds * 1e3, v->mesh_seconds * 1e3,
                v->frame_seconds * 1e3);
    ImGui::Text("%.1f MB, %u snapshots", static_cast<double>(s.memory) * 1e-6, v->snapshots);
    ImGui::TextDisabled("Space play, F1 help, Tab panel");
  }
  ImGui::End();
}

}  // namespace

weather_panel* weather_panel_create(GLFWwindow* window) {
  weather_panel* p = new (std::nothrow) weather_panel();
  if (p == nullptr) return nullptr;
  p->border_held = WEATHER_GRAPH_NONE;
  p->context = panel_frame_create(window);
  return p;
}

void weather_panel_destroy(weather_panel* p) {
  if (p == nullptr) return;
  panel_frame_destroy(p->context);
  delete p;
}

bool weather_panel_wants_pointer(const weather_panel*) {
  return ImGui::GetIO().WantCaptureMouse;
}
bool weather_panel_wants_keys(const weather_panel*) {
  return ImGui::GetIO().WantTextInput;
}

void weather_panel_draw(weather_panel* p, weather_panel_view* view, weather_panel_wishes* wishes) {
  *wishes = {};
  wishes->variant = view->variant;
  wishes->drop_age = wishes->drop_phase = UINT32_MAX;
  panel_frame_begin();
  if (view->panel) main_window(p, view, wishes);
  if (view->figures) figures_window(view);
  if (view->help) panel_keys(view->keys, &view->help);
  panel_message(view->message, view->message_is_error);
  wishes->held = ImGui::IsAnyItemActive();
  panel_frame_end();
}

bool weather_panel_graph(const weather_panel* p, float min[2], float max[2]) {
  min[0] = p->graph_min.x;
  min[1] = p->graph_min.y;
  max[0] = p->graph_max.x;
  max[1] = p->graph_max.y;
  return max[0] > min[0];
}
