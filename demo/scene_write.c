/* Scenes to JSON: every key in a fixed order, short arrays on one line, numbers as short as they can be read back. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "buffer.h"
#include "file.h"
#include "scene.h"

static void key(text_buffer* t, uint32_t indent, const char* name) {
  buffer_indent(t, indent);
  buffer_string(t, name);
  buffer_add(t, ": ");
}

static void end(text_buffer* t, bool last) {
  buffer_add(t, last ? "\n" : ",\n");
}

static void number_key(text_buffer* t, uint32_t indent, const char* name, double value) {
  key(t, indent, name);
  buffer_number(t, value);
}

static void string_key(text_buffer* t, uint32_t indent, const char* name, const char* value) {
  key(t, indent, name);
  buffer_string(t, value);
}

static void vector_key(text_buffer* t, uint32_t indent, const char* name, const double* value) {
  key(t, indent, name);
  buffer_add(t, "[");
  for (int i = 0; i < 3; ++i) {
    if (i > 0) buffer_add(t, ", ");
    buffer_number(t, value[i]);
  }
  buffer_add(t, "]");
}

static void colour(text_buffer* t, const float value[3]) {
  int channel[3];
  for (int i = 0; i < 3; ++i) channel[i] = (int)floorf(fminf(fmaxf(value[i], 0.0f), 1.0f) * 255.0f + 0.5f);
  buffer_format(t, "\"#%02x%02x%02x\"", channel[0], channel[1], channel[2]);
}

static void colour_key(text_buffer* t, uint32_t indent, const char* name, const float value[3]) {
  key(t, indent, name);
  colour(t, value);
}

static void bool_key(text_buffer* t, uint32_t indent, const char* name, bool value) {
  key(t, indent, name);
  buffer_add(t, value ? "true" : "false");
}

/* Behind another key. */
static void write_crop(text_buffer* t, uint32_t indent, const scene_height_map* map) {
  if (map->crop[2] == 0) return;
  end(t, false);
  key(t, indent, "crop");
  buffer_format(t, "[%u, %u, %u, %u]", map->crop[0], map->crop[1], map->crop[2], map->crop[3]);
}

/* All but the end of the last line. */
static void write_height_map(text_buffer* t, uint32_t indent, const scene_height_map* map) {
  string_key(t, indent, "file", map->file);
  end(t, false);
  number_key(t, indent, "spacing", map->spacing);
  end(t, false);
  number_key(t, indent, "low", map->low);
  end(t, false);
  number_key(t, indent, "high", map->high);
  write_crop(t, indent, map);
}

static bool is_zero(const double v[3]) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

/* All points on lines of their own, as they are read. */
static void write_points(text_buffer* t, uint32_t indent, const scene_node* node) {
  key(t, indent, "points");
  buffer_add(t, "[\n");
  for (uint32_t i = 0; i < node->point_count; ++i) {
    const scene_point* p = &node->points[i];
    const double corner[2] = {p->place[0], p->place[2]}, ball[4] = {p->place[0], p->place[1], p->place[2], p->radius};
    const uint32_t numbers = node->kind == SCREE_SHAPE_EXTRUSION ? 2 : 4;
    buffer_indent(t, indent + 1);
    buffer_add(t, "[");
    for (uint32_t k = 0; k < numbers; ++k) {
      if (k > 0) buffer_add(t, ", ");
      buffer_number(t, numbers == 2 ? corner[k] : ball[k]);
    }
    buffer_add(t, "]");
    end(t, i + 1 == node->point_count);
  }
  buffer_indent(t, indent);
  buffer_add(t, "]");
}

static void integer_key(text_buffer* t, uint32_t indent, const char* name, uint32_t value) {
  key(t, indent, name);
  buffer_format(t, "%u", value);
}

static void write_pattern(text_buffer* t, uint32_t indent, const scene_node* node) {
  string_key(t, indent, "pattern", scene_pattern_name(node->pattern.kind));
  end(t, false);
  number_key(t, indent, "spacing", node->pattern.spacing);
  end(t, false);
  number_key(t, indent, "radius", node->pattern.radius);
  /* What only waves have is kept for the other kinds where somebody has set it. */
  if (node->pattern.kind != SCREE_PATTERN_WAVES && node->pattern.amplitude == 0 && node->pattern.wavelength == 1) return;
  end(t, false);
  number_key(t, indent, "amplitude", node->pattern.amplitude);
  end(t, false);
  number_key(t, indent, "wavelength", node->pattern.wavelength);
}

static void write_parameters(text_buffer* t, uint32_t indent, const scene_node* node) {
  switch (node->kind) {
    case SCREE_SHAPE_SPHERE: number_key(t, indent, "radius", node->sphere.radius); break;
    case SCREE_SHAPE_BOX:
      vector_key(t, indent, "half", node->box.half);
      end(t, false);
      number_key(t, indent, "rounding", node->box.rounding);
      break;
    case SCREE_SHAPE_CAPSULE:
      vector_key(t, indent, "a", node->capsule.a);
      end(t, false);
      vector_key(t, indent, "b", node->capsule.b);
      end(t, false);
      number_key(t, indent, "radius", node->capsule.radius);
      break;
    case SCREE_SHAPE_CYLINDER:
      number_key(t, indent, "radius", node->cylinder.radius);
      end(t, false);
      number_key(t, indent, "half_height", node->cylinder.half_height);
      break;
    case SCREE_SHAPE_CONE:
      number_key(t, indent, "radius", node->cone.radius);
      end(t, false);
      number_key(t, indent, "height", node->cone.height);
      break;
    case SCREE_SHAPE_HEIGHTFIELD:
      write_height_map(t, indent, &node->heightfield.map);
      end(t, false);
      number_key(t, indent, "above", node->heightfield.above);
      end(t, false);
      number_key(t, indent, "below", node->heightfield.below);
      break;
    case SCREE_SHAPE_MESH:
      if (node->mesh.pack[0] != '\0') {
        string_key(t, indent, "pack", node->mesh.pack);
        end(t, false);
        integer_key(t, indent, "time", node->mesh.time);
        end(t, false);
        integer_key(t, indent, "lod", node->mesh.lod);
      } else
        string_key(t, indent, "file", node->mesh.file);
      if (node->mesh.resolution == 0) break;
      end(t, false);
      integer_key(t, indent, "resolution", node->mesh.resolution);
      break;
    case SCREE_SHAPE_ELLIPSOID: vector_key(t, indent, "radii", node->ellipsoid.radii); break;
    case SCREE_SHAPE_TORUS:
      number_key(t, indent, "radius", node->torus.radius);
      end(t, false);
      number_key(t, indent, "tube_radius", node->torus.tube_radius);
      break;
    case SCREE_SHAPE_EXTRUSION:
      write_points(t, indent, node);
      end(t, false);
      number_key(t, indent, "low", node->extrusion.low);
      end(t, false);
      number_key(t, indent, "high", node->extrusion.high);
      break;
    case SCREE_SHAPE_TUBE:
      write_points(t, indent, node);
      end(t, false);
      bool_key(t, indent, "closed", node->tube.closed);
      end(t, false);
      if (node->tube.subdivisions != 0) {
        integer_key(t, indent, "subdivisions", node->tube.subdivisions);
        end(t, false);
      }
      number_key(t, indent, "half_height", node->tube.half_height);
      break;
    case SCREE_SHAPE_BLOBS: write_points(t, indent, node); break;
    case SCREE_SHAPE_PATTERN: write_pattern(t, indent, node); break;
    case SCREE_SHAPE_SMOOTH_UNION: number_key(t, indent, "blend", node->group.blend); break;
    case SCREE_SHAPE_NOISE:
      number_key(t, indent, "amplitude", node->noise.amplitude);
      end(t, false);
      number_key(t, indent, "wavelength", node->noise.wavelength);
      end(t, false);
      integer_key(t, indent, "octaves", node->noise.octaves);
      end(t, false);
      integer_key(t, indent, "seed", node->noise.seed);
      break;
    case SCREE_SHAPE_HALF_SPACE:
    case SCREE_SHAPE_CALLBACK:
    case SCREE_SHAPE_UNION:
    case SCREE_SHAPE_INTERSECTION:
    case SCREE_SHAPE_DIFFERENCE: break;
  }
}

static bool has_parameters(scree_shape_kind kind) {
  return kind != SCREE_SHAPE_HALF_SPACE && (!scene_kind_is_group(kind) || kind == SCREE_SHAPE_SMOOTH_UNION);
}

static void write_node(text_buffer* t, uint32_t indent, const scene_node* node) {
  const char* word = scene_kind_name(node->kind);
  buffer_add(t, "{\n");
  string_key(t, indent + 1, "shape", word != NULL ? word : "");
  if (node->name[0] != '\0') {
    end(t, false);
    string_key(t, indent + 1, "name", node->name);
  }
  if (!is_zero(node->position)) {
    end(t, false);
    vector_key(t, indent + 1, "position", node->position);
  }
  if (!is_zero(node->rotation)) {
    end(t, false);
    vector_key(t, indent + 1, "rotation", node->rotation);
  }
  if (node->scale != 1) {
    end(t, false);
    number_key(t, indent + 1, "scale", node->scale);
  }
  if (has_parameters(node->kind)) {
    end(t, false);
    write_parameters(t, indent + 1, node);
  }
  if (scene_kind_is_group(node->kind)) {
    end(t, false);
    key(t, indent + 1, "children");
    buffer_add(t, "[\n");
    for (uint32_t i = 0; i < node->child_count; ++i) {
      buffer_indent(t, indent + 2);
      write_node(t, indent + 2, node->children[i]);
      end(t, i + 1 == node->child_count);
    }
    buffer_indent(t, indent + 1);
    buffer_add(t, "]");
  }
  if (node->kind == SCREE_SHAPE_NOISE && node->child_count > 0) {
    end(t, false);
    key(t, indent + 1, "child");
    write_node(t, indent + 1, node->children[0]);
  }
  end(t, true);
  buffer_indent(t, indent);
  buffer_add(t, "}");
}

static void write_filter(text_buffer* t, const scene_filter* filter) {
  buffer_add(t, "{\n");
  string_key(t, 5, "filter", scene_filter_name(filter->kind));
  end(t, false);
  if (filter->kind == SCREE_FILTER_MASK) {
    string_key(t, 5, "file", filter->map.file);
    end(t, false);
    number_key(t, 5, "spacing", filter->map.spacing);
    write_crop(t, 5, &filter->map);
    end(t, false);
  } else if (filter->kind == SCREE_FILTER_SLOPE) {
    write_height_map(t, 5, &filter->map);
    end(t, false);
  }
  if (filter->kind != SCREE_FILTER_ALTITUDE) {
    vector_key(t, 5, "position", filter->position);
    end(t, false);
  }
  if (filter->kind != SCREE_FILTER_MASK) {
    number_key(t, 5, "from", filter->from);
    end(t, false);
    number_key(t, 5, "to", filter->to);
    end(t, false);
    number_key(t, 5, "fade", filter->fade);
    end(t, false);
  }
  bool_key(t, 5, "inverted", filter->inverted);
  end(t, true);
  buffer_indent(t, 4);
  buffer_add(t, "}");
}

static void write_filters(text_buffer* t, const scene_field* field) {
  key(t, 3, "filters");
  buffer_add(t, "[\n");
  for (uint32_t i = 0; i < field->filter_count; ++i) {
    buffer_indent(t, 4);
    write_filter(t, &field->filters[i]);
    end(t, i + 1 == field->filter_count);
  }
  buffer_indent(t, 3);
  buffer_add(t, "]");
}

static void write_ages(text_buffer* t, const scene_filter* ages) {
  key(t, 3, "ages");
  buffer_add(t, "{\n");
  string_key(t, 4, "file", ages->map.file);
  end(t, false);
  number_key(t, 4, "spacing", ages->map.spacing);
  write_crop(t, 4, &ages->map);
  end(t, false);
  vector_key(t, 4, "position", ages->position);
  end(t, false);
  bool_key(t, 4, "inverted", ages->inverted);
  end(t, true);
  buffer_indent(t, 3);
  buffer_add(t, "}");
}

static void numbers_key(text_buffer* t, uint32_t indent, const char* name, const double* values, uint32_t count) {
  key(t, indent, name);
  for (uint32_t i = 0; i < count; ++i) {
    buffer_add(t, i > 0 ? ", " : "[");
    buffer_number(t, values[i]);
  }
  buffer_add(t, "]");
}

static void write_scatter(text_buffer* t, const scene_scatter* s) {
  number_key(t, 3, "spacing", s->spacing);
  end(t, false);
  numbers_key(t, 3, "scale", s->scale, 2);
  end(t, false);
  number_key(t, 3, "max_slope", s->max_slope);
  end(t, false);
  if (s->weight_count > 0) {
    numbers_key(t, 3, "weights", s->weights, s->weight_count);
    end(t, false);
  }
  if (s->has_ages) {
    write_ages(t, &s->ages);
    end(t, false);
  }
}

static void write_cliff(text_buffer* t, const scene_cliff* c) {
  integer_key(t, 3, "time", c->time);
  end(t, false);
  number_key(t, 3, "turn", c->turn);
  end(t, false);
  number_key(t, 3, "scale", c->scale);
  end(t, false);
  if (c->what == 0) return;
  string_key(t, 3, "what", c->what == SCREE_CLIFF_STANDING ? "standing" : "blocks");
  end(t, false);
}

static void write_models(text_buffer* t, const scene_scatter* s) {
  key(t, 3, "models");
  for (uint32_t i = 0; i < s->model_count; ++i) {
    buffer_add(t, i > 0 ? ", " : "[");
    buffer_string(t, s->models[i]);
  }
  buffer_add(t, "]");
}

static void write_field(text_buffer* t, const scene_field* field) {
  buffer_add(t, "{\n");
  if (field->name[0] != '\0') {
    string_key(t, 3, "name", field->name);
    end(t, false);
  }
  if (field->is_scatter && field->scatter.model_count > 0)
    write_models(t, &field->scatter);
  else
    string_key(t, 3, "pack", field->pack);
  end(t, false);
  key(t, 3, "seed");
  buffer_format(t, "%llu", (unsigned long long)field->seed);
  end(t, false);
  if (!field->is_scatter && !field->is_cliff) {
    number_key(t, 3, "cell_size", field->cell_size);
    end(t, false);
  }
  vector_key(t, 3, "origin", field->origin);
  end(t, false);
  if (field->is_scatter) {
    write_scatter(t, &field->scatter);
  } else if (field->is_cliff) {
    write_cliff(t, &field->cliff);
  } else {
    number_key(t, 3, "threshold", field->threshold);
    end(t, false);
    bool_key(t, 3, "shell", field->shell);
    end(t, false);
  }
  if (field->key >= 0) {
    integer_key(t, 3, "key", (uint32_t)field->key);
    end(t, false);
  }
  if (field->density != 1) {
    number_key(t, 3, "density", field->density);
    end(t, false);
  }
  if (field->filter_count > 0) {
    write_filters(t, field);
    end(t, false);
  }
  key(t, 3, "palette");
  buffer_add(t, "{\n");
  key(t, 4, "colours");
  buffer_add(t, "[");
  for (uint32_t i = 0; i < field->palette.colour_count; ++i) {
    if (i > 0) buffer_add(t, ", ");
    colour(t, field->palette.colours[i]);
  }
  buffer_add(t, "],\n");
  number_key(t, 4, "variation", field->palette.variation);
  end(t, true);
  buffer_indent(t, 3);
  buffer_add(t, "}");
  if (field->support != NULL) {
    end(t, false);
    key(t, 3, "support");
    write_node(t, 3, field->support);
  }
  end(t, true);
  buffer_indent(t, 2);
  buffer_add(t, "}");
}

static void write_ground(text_buffer* t, const scene_ground* ground) {
  static const char* const kinds[] = {"none", "plane", "terrain"};
  buffer_add(t, "{\n");
  string_key(t, 2, "kind", kinds[ground->kind]);
  end(t, false);
  colour_key(t, 2, "colour", ground->colour);
  if (ground->sand) {
    end(t, false);
    string_key(t, 2, "cover", "sand");
  }
  if (ground->kind == SCENE_GROUND_PLANE) {
    end(t, false);
    number_key(t, 2, "height", ground->height);
  } else if (ground->kind == SCENE_GROUND_TERRAIN) {
    end(t, false);
    write_height_map(t, 2, &ground->map);
    end(t, false);
    vector_key(t, 2, "position", ground->position);
    if (ground->water) {
      end(t, false);
      key(t, 2, "water");
      buffer_add(t, "{\n");
      number_key(t, 3, "height", ground->water_height);
      end(t, false);
      colour_key(t, 3, "colour", ground->water_colour);
      end(t, true);
      buffer_indent(t, 2);
      buffer_add(t, "}");
    }
  }
  end(t, true);
  buffer_indent(t, 1);
  buffer_add(t, "}");
}

char* scene_write(const scene_model* scene, size_t* size) {
  text_buffer t = {0};
  buffer_add(&t, "{\n");
  if (scene->schema[0] != '\0') {
    string_key(&t, 1, "$schema", scene->schema);
    end(&t, false);
  }
  string_key(&t, 1, "name", scene->name);
  end(&t, false);
  key(&t, 1, "camera");
  buffer_add(&t, "{\n");
  vector_key(&t, 2, "eye", scene->camera.eye);
  end(&t, false);
  vector_key(&t, 2, "target", scene->camera.target);
  end(&t, false);
  number_key(&t, 2, "fov", scene->camera.fov);
  buffer_add(&t, "\n  },\n");
  key(&t, 1, "sun");
  buffer_add(&t, "{\n");
  vector_key(&t, 2, "direction", scene->sun.direction);
  end(&t, false);
  colour_key(&t, 2, "colour", scene->sun.colour);
  buffer_add(&t, "\n  },\n");
  colour_key(&t, 1, "sky", scene->sky);
  end(&t, false);
  key(&t, 1, "ground");
  write_ground(&t, &scene->ground);
  end(&t, false);
  key(&t, 1, "fields");
  buffer_add(&t, "[");
  for (uint32_t i = 0; i < scene->field_count; ++i) {
    buffer_add(&t, i > 0 ? ",\n" : "\n");
    buffer_indent(&t, 2);
    write_field(&t, &scene->fields[i]);
  }
  buffer_add(&t, scene->field_count > 0 ? "\n  ]\n}\n" : "]\n}\n");
  return buffer_take(&t, size);
}

scree_result scene_save(const scene_model* scene, const char* file, scree_error* error) {
  size_t size;
  char* text = scene_write(scene, &size);
  if (text == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", file);
  file_replacement replacement;
  scree_result result = file_replace_begin(file, &replacement, error);
  if (result == SCREE_OK) {
    fwrite(text, 1, size, replacement.stream);
    result = file_replace_commit(&replacement, error);
  }
  free(text);
  return result;
}
