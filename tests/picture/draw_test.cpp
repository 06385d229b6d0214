// What lands where in a picture.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "picture/picture.h"

namespace foldproof {
namespace {

using ::testing::HasSubstr;

struct Mesh {
  Topology topology;
  std::vector<double> x;
  PictureMesh seen(Colour colour = colours::kClay) const { return {&topology, x, colour}; }
};

Mesh sphere(Index around, Index along, const Vec3& centre, double radius) {
  std::vector<double> x;
  std::vector<Triangle> triangles;
  for (Index i = 0; i <= along; ++i) {
    const double polar = std::numbers::pi * i / along;
    for (Index j = 0; j < around; ++j) {
      const double turn = 2 * std::numbers::pi * j / around;
      x.insert(x.end(),
               {centre.x() + radius * std::sin(polar) * std::cos(turn), centre.y() + radius * std::cos(polar),
                centre.z() - radius * std::sin(polar) * std::sin(turn)});
      if (i == along) continue;
      const Index a = i * around + j, b = i * around + (j + 1) % around;
      triangles.push_back({a, a + around, b});
      triangles.push_back({b, a + around, b + around});
    }
  }
  return {*Topology::make(around * (along + 1), std::move(triangles)), std::move(x)};
}

/// A square at height z that faces the eye.
Mesh square(double half, double z, const Vec3& middle = Vec3::Zero()) {
  const double x = middle.x(), y = middle.y();
  return {*Topology::make(4, {{0, 1, 2}, {0, 2, 3}}),
          {x - half, y - half, z, x + half, y - half, z, x + half, y + half, z, x - half, y + half, z}};
}

Colour at(const Image& image, Index x, Index y) { return image.pixels[std::size_t{y} * image.width + x]; }

Image drawn(std::vector<Panel> panels, const PictureSettings& settings) {
  auto image = draw_picture(panels, settings);
  EXPECT_TRUE(image) << image.error().line();
  return image ? *image : Image{1, 1, {Colour{}}};
}

const View kFlat{.perspective = false};

TEST(Picture, SphereCoversADisc) {
  const Mesh ball = sphere(128, 64, {3, -2, 7}, 5);
  for (const bool perspective : {false, true}) {
    SCOPED_TRACE(perspective);
    const Image image = drawn({{.meshes = {ball.seen()}, .view = {.perspective = perspective}}},
                              {.width = 300, .height = 200});
    ASSERT_EQ(image.pixels.size(), 60000u);
    // Fitted to 94 % of the height; in perspective the rim is behind the front that was fitted.
    double area = 0;
    Index least = 300, most = 0, top = 200, bottom = 0;
    for (Index y = 0; y < 200; ++y) {
      for (Index x = 0; x < 300; ++x) {
        if (at(image, x, y) == colours::kWhite) continue;
        ++area;
        least = std::min(least, x), most = std::max(most, x);
        top = std::min(top, y), bottom = std::max(bottom, y);
      }
    }
    const double radius = std::sqrt(area / std::numbers::pi);
    if (perspective) {
      EXPECT_GT(radius, 70);
      EXPECT_LT(radius, 94);
    } else {
      EXPECT_NEAR(radius, 94, 0.7);
    }
    EXPECT_NEAR(0.5 * (least + most), 149.5, 0.51);
    EXPECT_NEAR(0.5 * (top + bottom), 99.5, 0.51);
    EXPECT_NEAR(0.5 * (most - least + 1), radius, 1.2);  // round, and no holes
    EXPECT_NEAR(0.5 * (bottom - top + 1), radius, 1.2);
    EXPECT_NE(at(image, 150, 100), colours::kWhite);
  }
}

TEST(Picture, LightComesFromTheUpperLeft) {
  const Mesh ball = sphere(64, 32, {0, 0, 0}, 1);
  const Image image = drawn({{.meshes = {ball.seen()}}}, {.width = 100, .height = 100});
  EXPECT_GT(at(image, 35, 35).green, at(image, 65, 65).green + 20);
  EXPECT_GT(at(image, 65, 65).green, 40);  // nothing is black
}

TEST(Picture, StraightOnAColourIsItself) {
  const Mesh wall = square(1, 0);
  for (const bool perspective : {false, true}) {
    const View view{.perspective = perspective};
    for (const Colour colour : {colours::kRed, colours::kBlue, Colour{1, 2, 3}, Colour{250, 128, 7}}) {
      const Image image = drawn({{.meshes = {wall.seen(colour)}, .view = view}}, {.width = 40, .height = 40});
      EXPECT_EQ(at(image, 20, 20), colour);
      EXPECT_EQ(at(image, 3, 3), colour);
      EXPECT_EQ(at(image, 0, 0), colours::kWhite);
    }
  }
  // And from behind.
  const Image image = drawn({{.meshes = {wall.seen(colours::kRed)}, .view = {.from = {0, 0, -3}}}},
                            {.width = 40, .height = 40});
  EXPECT_EQ(at(image, 20, 20), colours::kRed);
}

TEST(Picture, NearHidesFar) {
  const Mesh far = square(1, -1), near = square(0.5, 1);
  for (const bool near_first : {true, false}) {
    for (const bool perspective : {true, false}) {
      std::vector<PictureMesh> meshes{far.seen(colours::kBlue), near.seen(colours::kRed)};
      if (near_first) std::swap(meshes[0], meshes[1]);
      const PictureSettings settings{.width = 60, .height = 60};
      const Image front = drawn({{.meshes = meshes, .view = {.perspective = perspective}}}, settings);
      EXPECT_EQ(at(front, 30, 30), colours::kRed);
      EXPECT_EQ(at(front, 13, 30), colours::kBlue);
      const Image back =
          drawn({{.meshes = meshes, .view = {.from = {0, 0, -1}, .perspective = perspective}}}, settings);
      EXPECT_EQ(at(back, 30, 30), colours::kBlue);
    }
  }
}

/// Two squares that cross: each is seen on the side where it is nearer.
TEST(Picture, CrossingTrianglesHideEachOtherInPart) {
  Mesh left_near = square(1, 0), right_near = square(1, 0);
  for (int k = 0; k < 4; ++k) {
    left_near.x[3 * k + 2] = -0.1 * left_near.x[3 * k];
    right_near.x[3 * k + 2] = 0.1 * right_near.x[3 * k];
  }
  const Image image =
      drawn({{.meshes = {left_near.seen(colours::kRed), right_near.seen(colours::kBlue)}, .view = kFlat}},
            {.width = 60, .height = 60});
  for (Index x = 5; x < 55; ++x) {
    if (x == 29 || x == 30) continue;
    const Colour c = at(image, x, 30);
    EXPECT_EQ(c.red > c.blue, x < 30) << x;
  }
}

/// A fan with its middle anywhere: no gap between neighbours shows what is behind.
TEST(Picture, TrianglesWithACommonSideLeaveNoGap) {
  const Mesh behind = square(1, -0.5);
  for (const double skew : {0.0, 0.1, 1.0 / 3}) {
    std::vector<double> x{skew, skew * skew, 0};
    std::vector<Triangle> triangles;
    for (Index k = 0; k < 101; ++k) {
      const double turn = 2 * std::numbers::pi * k / 101;
      x.insert(x.end(), {2 * std::cos(turn), 2 * std::sin(turn), 0});
      triangles.push_back({0, 1 + k, 1 + (k + 1) % 101});
    }
    const Mesh fan{*Topology::make(102, std::move(triangles)), x};
    for (const bool perspective : {true, false}) {
      const Image image = drawn({{.meshes = {behind.seen(colours::kRed), fan.seen(colours::kBlue)},
                                  .view = {.perspective = perspective, .focus = View::Focus{{0, 0, 0}, 1}}}},
                                {.width = 100, .height = 100});
      for (const Colour c : image.pixels) ASSERT_EQ(c, colours::kBlue);
    }
  }
}

TEST(Picture, FaceAndVertexColoursLand) {
  const Mesh wall = square(1, 0);
  PictureMesh faces = wall.seen();
  const std::vector<Colour> two{colours::kRed, colours::kBlue};
  faces.face_colours = two;
  const PictureSettings settings{.width = 100, .height = 100};
  const Image image = drawn({{.meshes = {faces}, .view = kFlat}}, settings);
  EXPECT_EQ(at(image, 70, 80), colours::kRed);  // the lower right triangle is the first
  EXPECT_EQ(at(image, 30, 20), colours::kBlue);

  PictureMesh vertices = wall.seen();
  const std::vector<Colour> four{{0, 0, 0}, {255, 0, 0}, {255, 255, 0}, {0, 255, 0}};
  vertices.vertex_colours = four;
  const Image blend = drawn({{.meshes = {vertices}, .view = kFlat}}, settings);
  for (const Index y : {10u, 50u, 90u}) {
    for (Index x = 5; x < 90; ++x) EXPECT_LE(at(blend, x, y).red, at(blend, x + 1, y).red);
  }
  // Half the light is 188 of 255 in sRGB.
  EXPECT_NEAR(at(blend, 50, 80).red, 188, 3);
  EXPECT_NEAR(at(blend, 20, 50).green, 188, 3);
  EXPECT_LT(at(blend, 4, 95).red, 60);
  EXPECT_GT(at(blend, 95, 5).green, 240);
}

/// A wall that leans back: the middle of its colours is seen above the middle of the picture of it.
TEST(Picture, ColoursOfATiltedWallFollowPerspective) {
  Mesh wall = square(1, 0);
  for (int k = 0; k < 4; ++k) wall.x[3 * k + 2] = -5 * wall.x[3 * k + 1];
  PictureMesh mesh = wall.seen();
  const std::vector<Colour> shades{{0, 0, 0}, {0, 0, 0}, {255, 0, 0}, {255, 0, 0}};
  mesh.vertex_colours = shades;
  const auto middle_of = [&](const View& view) {
    const Image image = drawn({{.meshes = {mesh}, .view = view}}, {.width = 200, .height = 200});
    Index top = 200, bottom = 0;
    int brightest = 0;
    for (Index y = 0; y < 200; ++y) {
      if (at(image, 100, y) == colours::kWhite) continue;
      top = std::min(top, y), bottom = std::max(bottom, y);
      brightest = std::max<int>(brightest, at(image, 100, y).red);
    }
    for (Index y = bottom; y > top; --y) {
      if (at(image, 100, y).red > brightest * 0.735) return static_cast<double>(bottom - y) / (bottom - top);
    }
    return 0.0;
  };
  EXPECT_NEAR(middle_of(kFlat), 0.5, 0.02);
  const double seen = middle_of({});
  EXPECT_GT(seen, 0.52);
  EXPECT_LT(seen, 0.9);
}

TEST(Picture, SmoothAndFlatDiffer) {
  const Mesh ball = sphere(12, 6, {0, 0, 0}, 1);
  PictureMesh flat = ball.seen();
  flat.smooth = false;
  const PictureSettings settings{.width = 120, .height = 120};
  const auto shades = [](const Image& image) {
    std::vector<std::uint8_t> values;
    for (const Colour c : image.pixels) values.push_back(c.green);
    std::sort(values.begin(), values.end());
    return std::unique(values.begin(), values.end()) - values.begin();
  };
  const Image smooth_image = drawn({{.meshes = {ball.seen()}}}, settings);
  const Image flat_image = drawn({{.meshes = {flat}}}, settings);
  EXPECT_NE(smooth_image.pixels, flat_image.pixels);
  // Inside, one shade per facet against a gradient.
  const auto row = [&](const Image& image) {
    int changes = 0;
    for (Index x = 40; x < 80; ++x) changes += at(image, x, 52) != at(image, x + 1, 52);
    return changes;
  };
  EXPECT_LT(row(flat_image), 12);
  EXPECT_GT(row(smooth_image), 25);
  EXPECT_GT(shades(smooth_image), 50);
}

TEST(Picture, PointsAreBallsOnTheSurface) {
  const Mesh wall = square(1, 0);
  Panel panel{.meshes = {wall.seen()},
              .points = {{{{0.5, 0.5, 0}, {-0.5, 0.5, -1}}, colours::kRed, 0.05}},
              .view = kFlat};
  const Image image = drawn({panel}, {.width = 200, .height = 200});
  // 2 units of extent are 188 pixels; a radius of 0.05 of the extent is 9.4 pixels.
  EXPECT_GT(at(image, 147, 53).red, 1.5 * at(image, 147, 53).green);
  int red = 0;
  for (const Colour c : image.pixels) red += c.red > 2 * c.green;
  EXPECT_NEAR(red, std::numbers::pi * 9.4 * 9.4, 30);  // the one behind the wall is hidden
  const Colour upper = at(image, 144, 50), lower = at(image, 151, 57);
  EXPECT_GT(upper.red, lower.red + 20);  // and it is round
}

TEST(Picture, FocusShowsAPart) {
  const Mesh wall = square(1, 0);
  PictureMesh mesh = wall.seen();
  const std::vector<Colour> two{colours::kRed, colours::kBlue};
  mesh.face_colours = two;
  for (const bool perspective : {true, false}) {
    View view{.perspective = perspective, .focus = View::Focus{{0.6, -0.6, 0}, 0.2}};
    const Image image = drawn({{.meshes = {mesh}, .view = view}}, {.width = 50, .height = 50});
    for (const Colour c : image.pixels) EXPECT_EQ(c, colours::kRed);
    view.focus->centre = {1, 0, 0};
    const Image edge = drawn({{.meshes = {mesh}, .view = view}}, {.width = 50, .height = 50});
    EXPECT_EQ(at(edge, 23, 40), colours::kRed);
    EXPECT_EQ(at(edge, 27, 40), colours::kWhite);
  }
}

TEST(Picture, PanelsStandSideBySide) {
  const Mesh small = square(0.5, 0), large = square(1, 0, {10, 20, 0});
  const std::vector<Panel> panels{{.meshes = {small.seen(colours::kRed)}, .view = kFlat},
                                  {.meshes = {large.seen(colours::kBlue)}, .view = kFlat},
                                  {.meshes = {small.seen(colours::kGreen)}, .view = kFlat}};
  const auto width_at = [](const Image& image, Index y, Colour colour) {
    Index count = 0;
    for (Index x = 0; x < image.width; ++x) count += at(image, x, y) == colour;
    return count;
  };
  const Image row = drawn(panels, {.width = 300, .height = 100});
  EXPECT_NEAR(width_at(row, 50, colours::kBlue), 94, 1);
  EXPECT_NEAR(width_at(row, 50, colours::kRed), 47, 1);
  EXPECT_EQ(at(row, 50, 50), colours::kRed);
  EXPECT_EQ(at(row, 150, 50), colours::kBlue);
  EXPECT_EQ(at(row, 250, 50), colours::kGreen);
  const Image own = drawn(panels, {.width = 300, .height = 100, .same_scale = false});
  EXPECT_NEAR(width_at(own, 50, colours::kRed), 94, 1);
  const Image grid = drawn(panels, {.width = 200, .height = 200});
  EXPECT_EQ(at(grid, 150, 50), colours::kBlue);
  EXPECT_EQ(at(grid, 50, 150), colours::kGreen);
  EXPECT_EQ(at(grid, 150, 150), colours::kWhite);
  const Image column = drawn(panels, {.width = 100, .height = 300, .columns = 1});
  EXPECT_EQ(at(column, 50, 250), colours::kGreen);
}

TEST(Picture, EdgesAreSmoothed) {
  const Mesh wall = square(1, 0);
  View turned = kFlat;
  turned.up = {0.3, 1, 0};
  const auto greys = [&](Index samples) {
    const Image image = drawn({{.meshes = {wall.seen({0, 0, 0})}, .view = turned}},
                              {.width = 64, .height = 64, .samples = samples});
    std::set<int> values;
    for (const Colour c : image.pixels) values.insert(c.red);
    return values.size();
  };
  EXPECT_EQ(greys(1), 2u);
  EXPECT_GT(greys(4), 10u);
}

TEST(Picture, TheSameForAnyNumberOfThreads) {
  const Mesh ball = sphere(200, 100, {0, 0, 0}, 1);
  const std::vector<Panel> panels{{.meshes = {ball.seen()}, .points = {{{{0, 0, 1}}}}}};
  const Image many = drawn(panels, {.width = 333, .height = 211});
  const ThreadLimit one(1);
  EXPECT_EQ(many.pixels, drawn(panels, {.width = 333, .height = 211}).pixels);
}

TEST(Picture, OddThingsAreDrawn) {
  const PictureSettings settings{.width = 20, .height = 20};
  const Image empty = drawn({Panel{}}, settings);
  EXPECT_EQ(at(empty, 10, 10), colours::kWhite);
  // All vertices in one place; a triangle seen from the side.
  const Mesh dot{*Topology::make(3, {{0, 1, 2}}), std::vector<double>(9, 4.0)};
  drawn({{.meshes = {dot.seen()}}}, settings);
  const Mesh side{*Topology::make(3, {{0, 1, 2}}), {0, 0, 0, 0, 1, 0, 0, 0, 1}};
  drawn({{.meshes = {side.seen()}, .view = kFlat}}, settings);
  const Mesh far{*Topology::make(3, {{0, 1, 2}}), {1e100, 0, 0, 2e100, 0, 0, 1e100, 1e100, 0}};
  EXPECT_NE(at(drawn({{.meshes = {far.seen()}}}, settings), 6, 13), colours::kWhite);
}

TEST(Picture, RefusesWhatCannotBeDrawn) {
  const Mesh wall = square(1, 0);
  const auto problem = [](std::vector<Panel> panels, const PictureSettings& settings = {}) {
    const auto image = draw_picture(panels, settings);
    return image ? std::string() : image.error().line();
  };
  EXPECT_THAT(problem({}), HasSubstr("no panel"));
  for (const PictureSettings& bad : std::vector<PictureSettings>{
           {.width = 0}, {.height = 0}, {.width = 20000}, {.width = 16000, .height = 16000}}) {
    EXPECT_THAT(problem({{.meshes = {wall.seen()}}}, bad), HasSubstr("pixels cannot be drawn"));
  }
  EXPECT_THAT(problem({{.meshes = {wall.seen()}}}, {.samples = 0}), HasSubstr("samples"));
  EXPECT_THAT(problem(std::vector<Panel>(9), {.width = 2, .height = 2}), HasSubstr("no room"));
  Mesh bad = wall;
  bad.x[4] = std::nan("");
  EXPECT_THAT(problem({{.meshes = {bad.seen()}}}), HasSubstr("not finite"));
  bad.x.pop_back();
  EXPECT_THAT(problem({{.meshes = {bad.seen()}}}), HasSubstr("number of positions"));
  bad = wall;
  bad.x[0] = 1e200;
  EXPECT_THAT(problem({{.meshes = {bad.seen()}}}), HasSubstr("too large"));
  PictureMesh coloured = wall.seen();
  const std::vector<Colour> three(3), two(2), four(4);
  coloured.face_colours = three;
  EXPECT_THAT(problem({{.meshes = {coloured}}}), HasSubstr("colours"));
  coloured.face_colours = two;
  coloured.vertex_colours = four;
  EXPECT_THAT(problem({{.meshes = {coloured}}}), HasSubstr("colours"));
  EXPECT_THAT(problem({{.meshes = {wall.seen()}, .view = {.from = {0, 0, 0}}}}), HasSubstr("direction"));
  EXPECT_THAT(problem({{.meshes = {wall.seen()}, .view = {.from = {0, 2, 0}}}}), HasSubstr("direction"));
  EXPECT_THAT(problem({{.meshes = {wall.seen()}, .view = {.focus = View::Focus{{0, 0, 0}, 0}}}}),
              HasSubstr("extent"));
  EXPECT_THAT(problem({{.points = {{{{0, 0, 0}}, colours::kRed, 0}}}}), HasSubstr("size for points"));
  EXPECT_THAT(problem({{.points = {{{{0, INFINITY, 0}}}}}}), HasSubstr("not finite"));
}

TEST(PictureView, IsRead) {
  EXPECT_EQ(parse_view("front")->from, Vec3(0, 0, 1));
  EXPECT_EQ(parse_view("back")->from, Vec3(0, 0, -1));
  EXPECT_EQ(parse_view("side")->from, Vec3(1, 0, 0));
  EXPECT_EQ(parse_view("top")->up, Vec3(0, 0, -1));
  EXPECT_EQ(parse_view("1,-2.5,1e1")->from, Vec3(1, -2.5, 10));
  EXPECT_TRUE(draw_picture(std::vector<Panel>{{.view = *parse_view("0,-3,0")}}, {.width = 4, .height = 4}));
  for (const char* bad : {"", "left", "1,2", "1,2,3,4", "0,0,0", "1,2,x", "nan,0,1", "1,inf,0"}) {
    const auto view = parse_view(bad);
    ASSERT_FALSE(view) << bad;
    EXPECT_THAT(view.error().line(), HasSubstr("--view"));
  }
}

}  // namespace
}  // namespace foldproof
