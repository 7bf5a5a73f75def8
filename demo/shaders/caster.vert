layout(location = 0) in vec3 position;
layout(location = 3) in vec4 place;
layout(location = 5) in vec2 turn; // sine and cosine

uniform mat4 clip_from_world_caster;

void main() {
  vec3 turned = vec3(turn.y * position.x + turn.x * position.z, position.y, turn.y * position.z - turn.x * position.x);
  gl_Position = clip_from_world_caster * vec4(place.xyz + turned * place.w, 1.0);
}
