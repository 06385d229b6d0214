// Names of outputs: never an input, and only what can be written.
#include <gmock/gmock.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <thread>

#include "apps/program.h"
#include "foldproof/model.h"
#include "model/cylinder.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::StartsWith;
namespace fs = std::filesystem;

/// A motion in every input format, with several names for the same files.
struct Inputs : TemporaryDirectory {
  Inputs() {
    const auto motion = bending_tube(kSmallTube, {0, 0.5, 1, 1.5});
    EXPECT_TRUE(write_npz(*this / "a.npz", *motion));
    EXPECT_TRUE(write_obj_pc2(*this / "walk.obj", *this / "walk.pc2", *motion));
    EXPECT_TRUE(save_model(small_learned_model(), *this / "tube.model"));
    write_frames(*this / "frames", *motion);
    fs::create_directories(*this / "lib/deep");
    fs::create_directories(*this / "plys");
    std::vector<double> x(std::size_t{motion->topology().vertex_count()} * 3);
    for (Index k = 0; k < 3; ++k) {
      EXPECT_TRUE(motion->read_frame(k, x));
      EXPECT_TRUE(write_ply(*this / ("plys/f" + std::to_string(k) + ".ply"), motion->topology(), x, {}));
    }
    fs::copy_file(*this / "a.npz", *this / "lib/deep/a.npz");
    write_file(*this / "p.csv", "0\n1\n");
    write_file(*this / "walk.gltf",
               R"({"asset":{"version":"2.0"},"images":[{"uri":"data:,x"}],"buffers":[{"uri":"b%20c.bin"}]})");
    write_file(*this / "b c.bin", "buffer");
    write_file(
        *this / "run.pvd",
        R"(<VTKFile type="Collection"><Collection><DataSet file="collected/f.vtp"/></Collection></VTKFile>)");
    fs::create_directories(*this / "collected");
    write_file(*this / "collected/f.vtp", "a mesh");
    fs::create_symlink("a.npz", *this / "soft");
    fs::create_hard_link(*this / "a.npz", *this / "hard");
    fs::create_directory_symlink("frames", *this / "elsewhere");
  }
  Outcome run(std::vector<std::string> arguments) const {
    return run_program(std::move(arguments), {.directory = path()});
  }
  /// Everything that is here.
  std::map<std::string, std::string> bytes() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(path())) {
      if (entry.is_regular_file()) all[entry.path().string()] = read_file(entry.path().string());
    }
    return all;
  }
};

using Words = std::vector<std::string>;

TEST(FileArguments, NothingIsWrittenOverWhatIsRead) {
  const Inputs inputs;
  const auto before = inputs.bytes();
  const std::string whole = inputs / "a.npz";
  const std::vector<std::pair<Words, std::string>> clashes{
      {{"check", "a.npz", "--json", "a.npz"},
       "--json a.npz: would write over 'a.npz', which is read (MOTION a.npz); name another file to write"},
      {{"check", "a.npz", "--csv", "./a.npz"}, "--csv ./a.npz: would write over 'a.npz'"},
      {{"check", "a.npz", "--vtk", "frames/../a.npz"}, "--vtk frames/../a.npz: would write over 'a.npz'"},
      {{"check", "./a.npz", "--csv", whole}, "--csv " + whole + ": would write over './a.npz'"},
      {{"check", "a.npz", "--ply", "soft"}, "--ply soft: would write over 'a.npz'"},
      {{"check", "soft", "--json", "a.npz"}, "--json a.npz: would write over 'soft'"},
      {{"check", "a.npz", "--json", "hard"}, "--json hard: would write over 'a.npz'"},
      {{"check", "walk.obj", "walk.pc2", "--json", "walk.pc2"}, "(MOTION walk.pc2)"},
      {{"check", "frames", "--csv", "frames/frame1.obj"},
       "would write over 'frames/frame1.obj', which is read (MOTION frames)"},
      {{"check", "frames", "--csv", "elsewhere/frame1.obj"}, "would write over 'frames/frame1.obj'"},
      {{"check", "frames/*.obj", "--json", "frames/frame0.obj"}, "(MOTION frames/*.obj)"},
      {{"check", "plys", "--ply", "plys/f%d.ply"}, "--ply plys/f%d.ply: would write over 'plys/f"},
      {{"check", "plys", "--ply", "plys/f%04d.ply"}, "--ply plys/f%04d.ply: would write over 'plys/f"},
      {{"check", "walk.gltf", "--json", "b c.bin"},
       "would write over 'b c.bin', which is read (MOTION walk.gltf)"},
      {{"check", "run.pvd", "--json", "collected/f.vtp"},
       "would write over 'collected/f.vtp', which is read (MOTION run.pvd)"},
      {{"check", "a.npz", "--model", "tube.model", "--json", "tube.model"}, "(--model tube.model)"},
      {{"check", "--reduced", "tube.model", "p.csv", "--csv", "p.csv"}, "(MOTION p.csv)"},
      {{"report", "a.npz", "-o", "a.npz"}, "-o a.npz: would write over 'a.npz'"},
      {{"render", "a.npz", "-o", "soft"}, "-o soft: would write over 'a.npz'"},
      {{"train", "a.npz", "frames", "-o", "frames/frame2.obj"}, "(POSES frames)"},
      {{"predict", "tube.model", "a.npz", "-o", "a.npz"}, "(KEYPOINTS a.npz)"},
      {{"predict", "tube.model", "frames/frame0.obj", "walk.pc2", "-o", "walk.obj"}, "'walk.pc2'"},
      {{"predict", "tube.model", "p.csv", "--truth", "a.npz", "-o", "./a.npz"}, "(--truth a.npz)"},
      {{"info", "tube.model", "--json", "tube.model"}, "(MODEL tube.model)"},
      {{"sweep", "lib", "-o", "lib/deep/a.npz"}, "(DIR lib)"},
      {{"sweep", "lib", "-o", "r.jsonl", "--summary", "lib/deep/a.npz"}, "--summary lib/deep/a.npz"},
  };
  for (const auto& [words, said] : clashes) expect_one_line_error(inputs.run(words), said);
  EXPECT_EQ(inputs.bytes(), before);
}

TEST(FileArguments, TwoOutputsAreTwoFiles) {
  const Inputs inputs;
  write_file(inputs / "x.csv", "old");
  fs::create_symlink("x.csv", inputs / "y.csv");
  const auto before = inputs.bytes();
  const std::vector<Words> twice{
      {"check", "a.npz", "--json", "new", "--csv", "./new"},
      {"check", "a.npz", "--json", "new", "--contacts-csv", "frames/../new"},
      {"check", "a.npz", "--csv", "x.csv", "--contacts-csv", "y.csv"},
      {"check", "plys", "--ply", "f%d.ply", "--csv", "./f%d.ply"},
      {"sweep", "lib", "-o", "r", "--summary", "./r"},
      {"check", "a.npz", "--json", "v", "--vtk", "v.pvd"},
      {"check", "a.npz", "--vtk", "v.pvd", "--csv", "./v"},
      {"check", "a.npz", "--ply", "plys/worst.ply", "--vtk", "plys.pvd"},
      {"check", "a.npz", "--ply", "w%d.ply", "--csv", "w9.ply"},
      {"check", "a.npz", "--ply", "w%04d.ply", "--csv", "frames/../w0.ply"},
      {"check", "a.npz", "--json", "-", "--csv", "/dev/stdout"},
  };
  for (const Words& words : twice) expect_one_line_error(inputs.run(words), "is named for two outputs");
  EXPECT_EQ(inputs.bytes(), before);
}

/// It would change the answer of the same command.
TEST(FileArguments, NoOutputBecomesAFrameOfAnInput) {
  const Inputs inputs;
  const auto before = inputs.bytes();
  const std::vector<Words> frames{{"check", "plys", "--ply", "plys/worst.ply"},
                                  {"check", "elsewhere", "--ply", "frames/worst.ply"},
                                  {"check", "plys/*.ply", "--ply", "./plys/worst.ply"},
                                  {"check", "plys/*.ply", "--ply", "plys/w%d.ply"},
                                  {"check", "plys/f%d.ply", "--ply", "plys/f12.ply"},
                                  {"check", "plys", "--vtk", "plys/run.pvd"},
                                  {"predict", "tube.model", "frames", "-o", "frames/again.npz"}};
  for (const Words& words : frames)
    expect_one_line_error(inputs.run(words), "would be a frame of what is read");
  EXPECT_EQ(inputs.bytes(), before);
  for (const char* elsewhere : {"worst.ply", "frames/worst.ply"}) {
    const Outcome outcome = inputs.run({"check", "plys", "--quiet", "--ply", elsewhere});
    EXPECT_LE(outcome.code, 1) << outcome.err;
  }
}

/// What goes there already must stay, and two outputs must not mix.
TEST(FileArguments, OtherNamesOfStandardOutputAreStandardOutput) {
  const Inputs inputs;
  fs::create_symlink("/proc/self/fd/1", inputs / "link");
  const auto in_shell = [&](const std::string& rest) {
    const std::string line =
        std::string("echo before > out; exec ") + FOLDPROOF_PROGRAM + " check a.npz " + rest;
    return run_program({"-c", line}, {.directory = inputs.path(), .program = "/bin/sh"});
  };
  for (const char* name : {"-", "/dev/stdout", "link", "out"}) {
    const Outcome outcome = in_shell(std::string("--csv ") + name + " >> out");
    EXPECT_LE(outcome.code, 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("steps checked")) << name;
    EXPECT_THAT(read_file(inputs / "out"), StartsWith("before\nframe,substep,kind,")) << name;
    EXPECT_THAT(read_file(inputs / "out"), ::testing::Not(HasSubstr("steps checked"))) << name;
    EXPECT_TRUE(fs::is_symlink(inputs / "link"));
  }
  expect_one_line_error(in_shell("--ply link"), "--ply link: cannot be standard output; name a file");
}

TEST(FileArguments, ClosedStandardOutputIsNotTheNextFile) {
  const Inputs inputs;
  const std::string line = std::string("exec ") + FOLDPROOF_PROGRAM + " check a.npz --csv a.csv --pairs >&-";
  const Outcome outcome = run_program({"-c", line}, {.directory = inputs.path(), .program = "/bin/sh"});
  EXPECT_LE(outcome.code, 1) << outcome.err;
  const std::string csv = read_file(inputs / "a.csv");
  EXPECT_THAT(csv, StartsWith("frame,substep,kind,"));
  EXPECT_THAT(csv, ::testing::Not(HasSubstr("meets")));
  EXPECT_THAT(csv, ::testing::Not(HasSubstr("steps checked")));
}

/// Commands up to the name of an output. Their inputs do not exist, which is noticed later.
const std::vector<Words> kOutputs{{"check", "none", "--json"},
                                  {"check", "none", "--csv"},
                                  {"check", "none", "--ply"},
                                  {"check", "none", "--vtk"},
                                  {"check", "none", "--contacts-csv"},
                                  {"check", "--reduced", "none", "none", "--csv"},
                                  {"report", "none", "-o"},
                                  {"render", "none", "-o"},
                                  {"train", "none", "-o"},
                                  {"predict", "none", "none", "-o"},
                                  {"sample", "none", "-o"},
                                  {"info", "none", "--json"},
                                  {"sweep", "none", "-o"},
                                  {"sweep", "none", "-o", "r.jsonl", "--summary"}};

TEST(FileArguments, OutputsNameWhatCanBeWrittenBeforeAnythingIsRead) {
  const Inputs inputs;
  const auto before = inputs.bytes();
  for (const Words& words : kOutputs) {
    const std::string option = words.back();
    const auto with = [&](const std::string& name) {
      Words all = words;
      all.push_back(name);
      return inputs.run(all);
    };
    expect_one_line_error(with(""), option + ": names nothing; name the file to write");
    for (const char* directory : {".", "frames", "frames/", "no/"})
      expect_one_line_error(with(directory),
                            option + " " + directory + ": cannot be written: it is a directory");
    expect_one_line_error(with("no/a.npz"),
                          option + " no/a.npz: cannot be written: there is no directory 'no'; make it");
    expect_one_line_error(with(std::string(300, 'x') + ".npz"), "cannot be written: the name is too long");
    expect_one_line_error(with("p.csv/a.npz"),
                          option + " p.csv/a.npz: cannot be written: 'p.csv' is no directory");
    // With a valid name, the error is about the input.
    const bool is_motion = words[0] == "predict" || words[0] == "sample";
    const Outcome outcome = with(is_motion ? "new.npz" : "new");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, StartsWith("foldproof: none")) << ::testing::PrintToString(words);
  }
  for (const Words& words : {Words{"predict", "none", "none"}, Words{"sample", "none"}}) {
    Words all = words;
    all.insert(all.end(), {"-o", "a.xyz"});
    expect_one_line_error(inputs.run(all),
                          "-o a.xyz: is not a format that is written here; name it .npz, .obj or .ply");
  }
  EXPECT_EQ(inputs.bytes(), before);
}

/// A motion must not be lost to a picture or a table, nor a file be named what it is not.
TEST(FileArguments, OutputsEndAsWhatTheyAre) {
  const Inputs inputs;
  const auto before = inputs.bytes();
  const std::vector<std::pair<Words, std::string>> mistakes{
      {{"check", "frames", "--json", "a.npz"},
       "--json a.npz: has the ending of a motion, .npz; name a file that"},
      {{"check", "a.npz", "--csv", "walk.pc2"}, "has the ending of a motion, .pc2"},
      {{"check", "a.npz", "--ply", "walk.obj"},
       "--ply walk.obj: ends in .obj, not in .ply; name another file"},
      {{"train", "frames", "-o", "a.npz"}, "has the ending of a motion, .npz"},
      {{"sweep", "plys", "-o", "walk.gltf"}, "has the ending of a motion, .gltf"},
      {{"sweep", "plys", "-o", "r.jsonl", "--summary", "a.npz"}, "ends in .npz, not in .html or .htm"},
      {{"render", "frames", "-o", "a.npz"}, "-o a.npz: ends in .npz, not in .png"},
      {{"render", "frames", "-o", "a.jpg"}, "-o a.jpg: ends in .jpg, not in .png"},
      {{"report", "frames", "-o", "a.pdf"}, "-o a.pdf: ends in .pdf, not in .html or .htm"}};
  for (const auto& [words, said] : mistakes) expect_one_line_error(inputs.run(words), said);
  EXPECT_EQ(inputs.bytes(), before);
}

TEST(FileArguments, NothingIsWrittenWhereThatIsNotAllowed) {
  const Inputs inputs;
  fs::create_directory(inputs / "shut");
  fs::permissions(inputs / "shut", fs::perms::owner_read | fs::perms::owner_exec);
  Words words{"train", "none", "-o", "shut/a.model"};
  RunOptions options{.directory = inputs.path()};
  if (::geteuid() == 0) {  // who may write anywhere, unless that is taken away
    const char* right = "-dac_override,-dac_read_search";
    words.insert(words.begin(), {"--bounding-set", right, "--inh-caps", right, FOLDPROOF_PROGRAM});
    options.program = "/usr/bin/setpriv";
  }
  expect_one_line_error(run_program(words, options),
                        "-o shut/a.model: cannot be written: nothing may be written into 'shut'");
  fs::permissions(inputs / "shut", fs::perms::owner_all);
}

TEST(FileArguments, WhatIsNotReadMayBeReplaced) {
  const Inputs inputs;
  write_file(inputs / "frames/answer.json", "of yesterday");
  write_file(inputs / "other.pc2", "of yesterday");
  const auto good = [&](const Words& words) {
    const Outcome outcome = inputs.run(words);
    EXPECT_LE(outcome.code, 1) << outcome.err;
    EXPECT_EQ(outcome.err, "");
  };
  good({"check", "frames", "--quiet", "--json", "frames/answer.json", "--csv", "/dev/null"});
  EXPECT_THAT(read_file(inputs / "frames/answer.json"), StartsWith("{"));
  good({"predict", "tube.model", "a.npz", "--quiet", "-o", "other.obj"});
  EXPECT_NE(read_file(inputs / "other.pc2"), "of yesterday");
  good({"check", "a.npz", "--quiet", "--vtk", "a.pvd"});
  good({"check", "a.npz", "--quiet", "--vtk", "a.pvd"});
  good({"sweep", "lib", "--quiet", "-o", "lib/r.jsonl", "--summary", "lib/page.html"});
  good({"sweep", "lib", "--quiet", "-o", "lib/r.jsonl", "--summary", "lib/page.html"});
}

/// A full disk causes an error and leaves no files.
TEST(FileArguments, AFullDiskIsAnErrorAndLeavesNothing) {
  const Inputs inputs;
  for (const char* name : {"full.npz", "full.obj", "full.ply", "full.png"})
    fs::create_symlink("/dev/full", inputs / name);
  const auto before = inputs.bytes();
  const std::vector<Words> all{
      {"check", "a.npz", "--json", "/dev/full"},
      {"check", "a.npz", "--csv", "/dev/full"},
      {"check", "a.npz", "--ply", "/dev/full"},
      {"check", "a.npz", "--contacts-csv", "/dev/full"},
      {"render", "a.npz", "--size", "40x30", "-o", "full.png"},
      {"train", "a.npz", "-o", "/dev/full"},
      {"predict", "tube.model", "a.npz", "-o", "full.npz"},
      {"info", "tube.model", "--json", "/dev/full"},
      {"sweep", "lib", "-o", "r.jsonl", "--summary", "/dev/full"},
  };
  for (const Words& words : all) {
    expect_one_line_error(inputs.run(words), "No space left on device");
    fs::remove(inputs / "r.jsonl");
  }
  EXPECT_EQ(inputs.bytes(), before);
}

TEST(FileArguments, ALimitOnFileSizesIsAnErrorAndLeavesNothing) {
  const Inputs inputs;
  const auto before = inputs.bytes();
  for (const char* rest :
       {"check a.npz --json a.json", "train a.npz -o a.model", "predict tube.model a.npz -o b.npz"}) {
    const std::string line = std::string("ulimit -f 1 && exec ") + FOLDPROOF_PROGRAM + " " + rest;
    expect_one_line_error(run_program({"-c", line}, {.directory = inputs.path(), .program = "/bin/sh"}),
                          "cannot be written: File too large");
  }
  EXPECT_EQ(inputs.bytes(), before);
}

TEST(FileArguments, InputsHaveNames) {
  const Inputs inputs;
  const std::vector<std::pair<Words, const char*>> nameless{{{"check", ""}, "MOTION"},
                                                            {{"view", "a.npz", "--model", ""}, "--model"},
                                                            {{"train", "a.npz", "", "-o", "x"}, "POSES"},
                                                            {{"predict", "tube.model", ""}, "KEYPOINTS"},
                                                            {{"info", ""}, "MODEL"},
                                                            {{"sweep", "", "-o", "r.jsonl"}, "DIR"}};
  for (const auto& [words, option] : nameless)
    expect_one_line_error(inputs.run(words),
                          std::string(option) + ": names nothing; name what is to be read");
}

/// Interrupts a program that is at work.
Outcome interrupted(const Inputs& inputs, const Words& words, int signal = SIGINT) {
  return run_program(
      words, {.directory = inputs.path(), .while_it_runs = [&](pid_t child) { interrupt(child, signal); }});
}

TEST(InterruptedProgram, LeavesNothingAndSaysSo) {
  const Inputs inputs;
  const TubeShape fine{96, 160};
  std::vector<double> angles(40);
  for (std::size_t k = 0; k < angles.size(); ++k) angles[k] = 0.15 * static_cast<double>(k);
  ASSERT_TRUE(write_npz(inputs / "long.npz", *bending_tube(fine, angles)));
  for (double& angle : angles) angle /= 4;
  angles.resize(8'000, 1.2);
  ASSERT_TRUE(write_npz(inputs / "many.npz", *bending_tube(kSmallTube, angles)));
  std::string csv;
  const Index modes = load_model(inputs / "tube.model").value().learned->pca.modes();
  for (int k = 0; k < 100'000; ++k) {
    csv += k % 2 ? "0.1" : "0";
    for (Index mode = 1; mode < modes; ++mode) csv += ",0";
    csv += '\n';
  }
  write_file(inputs / "long.csv", csv);
  const auto before = inputs.bytes();
  const Words hang_up{"check", "long.npz", "--substeps", "1000000", "--csv", "a.csv"};
  EXPECT_EQ(interrupted(inputs, hang_up, SIGHUP).code, 130);
  const std::vector<std::pair<Words, std::string>> all{
      {{"render", "long.npz", "--color", "contacts", "--frame", "8", "--size", "4000x3000", "-o", "a.png"},
       "the picture was not finished; nothing was written"},
      {{"check", "long.npz", "--substeps", "1000000", "--json", "a.json"}, "no report was written"},
      {{"train", "long.npz", "-o", "a.model"}, "no model was written"},
      {{"check", "--reduced", "tube.model", "long.csv", "--csv", "a.csv"}, "no report was written"},
      {{"predict", "tube.model", "many.npz", "-o", "a.npz"}, "the prediction was not finished"},
  };
  for (const auto& [words, said] : all) {
    for (const int signal : {SIGINT, SIGTERM}) {
      const Outcome outcome = interrupted(inputs, words, signal);
      EXPECT_EQ(outcome.signal, 0) << words[0];
      EXPECT_EQ(outcome.code, 130) << words[0] << outcome.err;
      EXPECT_EQ(outcome.out, "") << words[0];
      EXPECT_THAT(outcome.err, StartsWith("foldproof: interrupted: "));
      EXPECT_THAT(outcome.err, HasSubstr(said));
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
  }
  EXPECT_EQ(inputs.bytes(), before);
}

}  // namespace
}  // namespace foldproof
