// Vertices are fetched from textures by index. Frames are uploaded as received with the normals of their vertices, and the GPU
// interpolates between two frames. Positions are relative to the scene's center, in mesh units.

const kFetch = /* glsl */ `
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
uniform sampler2D posA, posB;
uniform float blend;
uniform float scale;
vec3 at(sampler2D positions, int vertex) {
  int width = textureSize(positions, 0).x;
  return texelFetch(positions, ivec2(vertex % width, vertex / width), 0).xyz;
}
vec3 vertexPosition(int vertex) {
  return mix(at(posA, vertex), at(posB, vertex), blend) * scale;
}
`;

// GLOW: a pass that draws marked triangles that are hidden. GHOST: the passes that draw what is see-through, over all that is
// solid: first its depth, then its nearest layer, blended. So it is smooth, and the order of triangles does not matter.
const kBiasText = '0.00002'; // in depth: what is marked lies before what coincides with it
export const kSurfaceVertex = /* glsl */ `
${kFetch}
in uint vertex;
uniform sampler2D refA, refB, normalA, normalB;
uniform usampler2D faces, contact, painted;
uniform int triangles;
uniform int surface;       // 0 plain, 1 level, 2 margin, 3 error
uniform float order;        // in [0,1), another for each object
uniform bool hasFaces, showInside, showMeets, showContact, showPainted;
uniform uint insideBit;     // 2 at the step's begin, 4 at its end
uniform float errorScale;
uniform vec3 plain, red;
uniform vec3 reasonColors[8];
uniform vec3 marginRamp[9];
uniform vec3 nothing;
out vec3 eye;
out vec3 place;              // in the scene
out vec3 smoothNormal;
out vec3 corner;
out float distanceRatio;
out float held;               // painted: 1 at such vertices, 0 at others
flat out vec3 color;
flat out int marked;         // 1 is inside now, 2 meets in the step
flat out int part;           // of the chosen contact: 1 and 2 the first side, crossing and inside, 3 and 4 the second; 0 none

uint markOf(usampler2D marks, int k) {
  int width = textureSize(marks, 0).x;
  return texelFetch(marks, ivec2(k % width, k / width), 0).r;
}
uint faceData(int plane, int face) {
  int width = textureSize(faces, 0).x;
  int k = plane * triangles + face;
  return texelFetch(faces, ivec2(k % width, k / width), 0).r;
}
vec3 levelColor(int level) {
  if (level < 0) return nothing;
  float pale = float(min(level, 15) * 12);
  return vec3(pale, 60.0 + pale, 128.0 + pale * 2.0 / 3.0) / 255.0;
}
void main() {
  int v = int(vertex), face = gl_VertexID / 3, side = gl_VertexID % 3;
  vec3 p = vertexPosition(v);
  vec4 seen = modelViewMatrix * vec4(p, 1.0);
  eye = seen.xyz;
  place = p;
  smoothNormal = mat3(modelViewMatrix) * mix(at(normalA, v), at(normalB, v), blend);
  corner = vec3(side == 0, side == 1, side == 2);
  color = plain;
  marked = 0;
  distanceRatio = 0.0;
  held = showPainted ? float(markOf(painted, v)) : 0.0;
  uint marks = hasFaces ? faceData(0, face) : 0u;
  if (showMeets && (marks & 1u) != 0u) marked = 2;
  if (showInside && (marks & insideBit) != 0u) marked = 1;
  if (hasFaces && surface != 3) {
    if (surface == 1 || surface == 2) {
      int reason = int(faceData(1, face));
      int level = int(faceData(2, face));
      if (level > 127) level -= 256;
      color = reasonColors[min(reason, 7)];
      if (reason == 0 && surface == 1) color = levelColor(level);
      if (reason == 0 && surface == 2) {
        float margin = float(faceData(3, face)) / 255.0 * 8.0;
        int k = min(int(margin), 7);
        color = level < 0 ? nothing : mix(marginRamp[k], marginRamp[k + 1], margin - float(k));
      }
    }
  }
  if (surface == 3) {
    vec3 other = mix(at(refA, v), at(refB, v), blend) * scale;
    distanceRatio = length(p - other) / (scale * max(errorScale, 1e-30));
  }
  // The sides of the chosen contact, where they are inside now.
  part = showContact && (!hasFaces || (marks & insideBit) != 0u) ? int(markOf(contact, face)) : 0;
  gl_Position = projectionMatrix * seen;
  // Where surfaces coincide, what is marked is seen, else always the same one; and nothing shines through itself.
  gl_Position.z -= ${kBiasText} * gl_Position.w * (marked != 0 || part != 0 ? 2.0 : order);
#ifdef GLOW
  gl_Position.z -= ${kBiasText} * gl_Position.w * 2.0;
  if (marked == 0 && part == 0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // outside of the picture
#endif
}
`;

export const kSurfaceFragment = /* glsl */ `
precision highp float;
precision highp int;
in vec3 eye;
in vec3 place;
in vec3 smoothNormal;
in vec3 corner;
in float distanceRatio;
in float held;
flat in vec3 color;
flat in int marked;
flat in int part;
uniform int surface;
uniform vec3 red, pink, first, second, paintedColor;
uniform vec4 focus;          // the chosen contact: its place before the eye and its radius; radius 0: none
uniform int nearSide;        // its side that is nearer to the eye, 1 or 2
uniform vec4 clip;           // what is beyond this plane is cut away
uniform vec3 errorRamp[9];
uniform bool edges, seeThrough;
uniform vec3 edgeColor;
out vec4 result;

/** Light from above and a bright rim, as on a sphere of clay. */
float matcap(vec3 n) {
  float key = max(0.0, dot(n, normalize(vec3(-0.35, 0.55, 0.75))));
  float rim = pow(1.0 - abs(n.z), 3.0);
  return 0.42 + 0.5 * key + 0.1 * n.y + 0.1 * pow(key, 24.0) + 0.1 * rim;
}
/** How solid what is between the eye and the chosen contact is: least before its middle. */
float solidBefore() {
  if (focus.w == 0.0 || eye.z < focus.z) return 1.0;
  float aside = length(eye.xy * (focus.z / eye.z) - focus.xy);
  return mix(0.2, 1.0, smoothstep(0.4 * focus.w, focus.w, aside));
}
void main() {
  if (dot(place, clip.xyz) > clip.w) discard;
  bool stripe = mod(gl_FragCoord.x + gl_FragCoord.y, 9.0) < 4.5;
  float solid = 1.0;
#ifdef GLOW
  if (part != 0 && focus.w > 0.0) discard; // What is before the chosen contact is see-through already.
#else
  solid = part == 0 ? solidBefore() : (part + 1) / 2 == nearSide ? 0.65 : 1.0;
  if (seeThrough && marked == 0 && part == 0) solid = min(solid, 0.35);
#ifdef GHOST
  if (solid > 0.99) discard;
#else
  if (solid <= 0.99) discard;
  solid = 1.0;
#endif
#endif
  vec3 base = color;
  if (surface == 3) {
    float e = clamp(distanceRatio, 0.0, 1.0) * 8.0;
    int k = min(int(e), 7);
    base = mix(errorRamp[k], errorRamp[k + 1], e - float(k));
  }
  base = mix(base, paintedColor, 0.85 * smoothstep(0.35, 0.65, held));
  // Over meaningful colors, marks are striped to distinguish them.
  if (marked != 0) base = surface == 0 || stripe ? (marked == 1 ? red : pink) : vec3(1.0);
  if (part != 0) base = part < 3 ? first : second;
  if (part == 1 || part == 3) base = mix(base, vec3(1.0), 0.25);
#ifdef GLOW
  result = vec4(base, 0.4);
  return;
#endif
  vec3 normal = cross(dFdx(eye), dFdy(eye));
  float size = length(normal);
  normal = size > 0.0 ? normal / size : vec3(0.0, 0.0, 1.0);
  vec3 bent = dot(smoothNormal, smoothNormal) > 0.0 ? normalize(smoothNormal) : normal;
  if (dot(bent, normal) < 0.0) bent = -bent;
  // Sharp edges stay sharp. The change is gradual: else rims of closed tubes, where it is near, shimmer.
  normal = normalize(mix(normal, bent, smoothstep(0.6, 0.95, dot(bent, normal))));
  vec3 shaded = base * min(matcap(normal), 1.12);
  if (!gl_FrontFacing) shaded *= 0.72;
  if (edges) {
    vec3 width = fwidth(corner);
    vec3 near = smoothstep(vec3(0.0), width * 1.2, corner);
    float line = 1.0 - min(near.x, min(near.y, near.z));
    // Edges fade out where triangles are as small as pixels.
    float strength = 1.0 - smoothstep(0.15, 0.6, max(width.x, max(width.y, width.z)));
    shaded = mix(shaded, edgeColor, 0.75 * line * strength);
  }
  result = vec4(min(shaded, 1.0), solid);
}
`;

/** Marks of a size in pixels: round, the first impact a diamond and the last a square. Those still to come are pale. */
export const kPointVertex = /* glsl */ `
${kFetch}
#ifdef BY_VERTEX
in uint vertex;
uniform vec3 only;
#else
in vec3 position_;
in float toi;
uniform vec3 timeRamp[9];
uniform float now, firstTime, lastTime;
#endif
uniform float size, farthest;
out vec3 color;
flat out int shape; // 0 round, 1 diamond, 2 square
out float strength;
void main() {
#ifdef BY_VERTEX
  vec3 p = vertexPosition(int(vertex));
  color = only;
  shape = 0;
  strength = 1.0;
#else
  vec3 p = position_;
  float e = clamp(toi, 0.0, 1.0) * 8.0;
  int k = min(int(e), 7);
  color = mix(timeRamp[k], timeRamp[k + 1], e - float(k));
  shape = toi <= firstTime ? 1 : toi >= lastTime ? 2 : 0;
  strength = now >= toi - 1e-6 ? 1.0 : 0.45;
#endif
  vec4 seen = viewMatrix * vec4(p, 1.0);
  gl_Position = projectionMatrix * seen;
  gl_Position.z -= 0.0004 * gl_Position.w; // in front of its surface
  gl_PointSize = shape == 0 ? size : size * 1.5;
  if (-seen.z > farthest) gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // outside of the picture
}
`;

export const kPointFragment = /* glsl */ `
precision highp float;
in vec3 color;
flat in int shape;
in float strength;
uniform float opacity, size;
out vec4 result;
void main() {
  vec2 at = abs(gl_PointCoord - 0.5) * 2.0;
  float r = shape == 1 ? at.x + at.y : shape == 2 ? max(at.x, at.y) * 1.25 : length(at);
  if (r > 1.0) discard;
  // The rim is 1.5 pixels wide, and paler on small points, which it would otherwise dominate.
  bool rim = r > 1.0 - 3.0 / size;
  vec3 dark = size < 8.0 ? color * 0.45 : vec3(0.05, 0.07, 0.09);
  result = vec4(rim ? dark : color, opacity * strength);
}
`;

/** Lines of a width in pixels between two vertices of the mesh. */
export const kLineVertex = /* glsl */ `
${kFetch}
in uint from, to;
in float end, across; // 0 or 1 along the line, -1 or 1 across it
uniform vec2 viewport;
uniform float width;
void main() {
  vec4 a = projectionMatrix * viewMatrix * vec4(vertexPosition(int(from)), 1.0);
  vec4 b = projectionMatrix * viewMatrix * vec4(vertexPosition(int(to)), 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * viewport;
  float size = length(along);
  along = size > 1e-6 ? along / size : vec2(1.0, 0.0);
  vec4 p = mix(a, b, end);
  vec2 offset = vec2(-along.y, along.x) * across + along * (end * 2.0 - 1.0);
  p.xy += offset * width / viewport * p.w;
  gl_Position = p;
}
`;

export const kFlatFragment = /* glsl */ `
precision highp float;
uniform vec3 only;
uniform float opacity;
out vec4 result;
void main() { result = vec4(only, opacity); }
`;

export const kBoxVertex = /* glsl */ `
precision highp float;
in vec3 corner;
in vec3 low, high;
uniform float scale;
void main() {
  vec3 p = mix(low, high, corner) * scale;
  gl_Position = projectionMatrix * viewMatrix * vec4(p, 1.0);
}
`;
