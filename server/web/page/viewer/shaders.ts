// GLSL of the surfaces and of the marks. Colours are in sRGB: with plain colours a pixel is byte for byte that of
// api/map/colour_map.h. Normals come from the derivatives of the position, so that each triangle is flat without buffers of
// its own.

export const kSurfaceVertex = /* glsl */ `
uniform float size;       // of the meshes: squares of what is divided by it neither vanish nor overflow
in float deviation;
out float vDeviation;
#ifdef SIDES
in float side;            // 1 outside of the other mesh, -1 inside
out float vSigned;
#endif
out vec3 vView;
void main() {
#ifdef SIDES
  vSigned = side * deviation;
#endif
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  vView = view.xyz / size;
  vDeviation = deviation;
  gl_Position = projectionMatrix * view;
  gl_PointSize = 4.0;
}`;

const kCommon = /* glsl */ `
uniform vec4 clip;        // in the camera's frame, in sizes; what is below 0 is cut away
uniform bool clipped;
uniform bool outward;     // whether fronts look outwards
uniform vec3 faded;
uniform vec2 brush;       // distances that are highlighted
uniform bool brushed;
uniform bool plain;
in float vDeviation;
in vec3 vView;
out vec4 colour;

bool cutAway() { return clipped && dot(clip, vec4(vView, 1.0)) < 0.0; }
bool isInside() { return gl_FrontFacing != outward; }
bool outOfBrush() { return brushed && (vDeviation < brush.x || vDeviation > brush.y); }

vec3 normalToViewer() {
#ifdef CLOUD
  return -normalize(vView);  // points have no slope
#endif
  vec3 normal = normalize(cross(normalize(dFdx(vView)), normalize(dFdy(vView))));
  return dot(normal, vView) > 0.0 ? -normal : normal;
}
// A light beside the viewer. Surfaces that face the viewer keep their colour; slopes towards the light get lighter, others
// darker, so that the hue stays and dark colours show form as well.
vec3 lit(vec3 base) {
#ifdef CLOUD
  return base;
#endif
  if (plain) return base;
  vec3 normal = normalToViewer();
  float side = dot(normal, normalize(vec3(-0.42, 0.5, 0.76))) - 0.72;
  float rim = 1.0 - abs(dot(normal, normalize(vView)));
  vec3 shaded = side < 0.0 ? base * (1.0 + 0.6 * side) : mix(base, base * 1.5 + 0.3, 2.2 * side);
  return mix(shaded, shaded * 0.72, rim * rim * rim);
}`;

export const kColouredFragment = /* glsl */ `
uniform sampler2D table;
uniform float top;
uniform float limits[3];  // by row of the table
uniform vec3 above[3];
uniform vec3 section;
#ifdef SIDES
in float vSigned;
#endif
${kCommon}
vec3 mapped() {
#ifdef SIDES
  int row = vSigned < 0.0 ? 2 : 1;
#else
  int row = 0;
#endif
  if (vDeviation > limits[row] && vDeviation > 0.0) return above[row];
  float at = vDeviation <= 0.0 ? 0.0 : clamp(vDeviation / top, 0.0, 1.0) * float(STEPS) + 0.5;
  return texelFetch(table, ivec2(int(at), row), 0).rgb;
}
vec3 hatched() {
  float stripe = mod(gl_FragCoord.x + gl_FragCoord.y, 9.0);
  return section * (stripe < 1.6 ? 0.82 : 1.0);
}
void main() {
  if (cutAway()) discard;
  if (clipped && isInside()) colour = vec4(hatched(), 1.0);
  else colour = vec4(lit(outOfBrush() ? faded : mapped()), 1.0);
}`;

// Like glass: more opaque at grazing angles, so that form shows and the colours below stay as they are.
export const kOverlayFragment = /* glsl */ `
uniform vec3 tint;
uniform float opacity;
${kCommon}
void main() {
  if (cutAway()) discard;
  vec3 normal = normalToViewer();
  float rim = 1.0 - abs(dot(normal, normalize(vView)));
  float share = opacity >= 1.0 ? 1.0 : opacity * mix(0.45, 1.5, rim * rim);
  colour = vec4(lit(tint), clamp(share, 0.0, 1.0));
}`;

export const kLineFragment = /* glsl */ `
uniform vec3 line;
uniform float strength;
${kCommon}
void main() {
  if (cutAway()) discard;
  colour = vec4(line, strength);
}`;

// Marks are placed by the processor, in double precision.
export const kMarkVertex = /* glsl */ `
in vec3 local;   // CSS pixels from the middle of a mark, or across a segment; z: what it is
out vec3 vLocal;
void main() {
  vLocal = local;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

export const kMarkFragment = /* glsl */ `
uniform vec3 mark;
uniform float pixel;   // of the picture, in CSS pixels
in vec3 vLocal;
out vec4 colour;
// 0: segment, 1: disc, 2: square on its tip; 0.5 more: hidden by the surface, an outline with its middle
float shapeDistance(vec2 p, float kind) {
  if (kind < 0.75) return abs(p.y) - 1.25;
  if (kind < 1.75) return length(p) - 6.0;
  return (abs(p.x) + abs(p.y) - 7.5) * 0.70711;
}
void main() {
  float kind = vLocal.z;
  float far = shapeDistance(vLocal.xy, kind);
  float fill = far;
  if (fract(kind) > 0.25 && kind > 0.75) fill = min(max(far, -2.2 - far), length(vLocal.xy) - 1.6);
  float inner = clamp(0.5 - fill / pixel, 0.0, 1.0);
  float halo = clamp(0.5 - (far - 1.5) / pixel, 0.0, 1.0);
  colour = vec4(mix(vec3(1.0), mark, inner), max(inner, halo * 0.92));
}`;
