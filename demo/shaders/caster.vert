layout(location = 0) in vec3 position;
layout(location = 3) in vec4 place;

uniform mat4 clip_from_world_caster;

void main() {
  gl_Position = clip_from_world_caster * vec4(place.xyz + position * place.w, 1.0);
}
