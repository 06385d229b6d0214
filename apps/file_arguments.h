/// The files that a command line names, looked at before anything is read: writing must not take away what is
/// still to be read, and long work must not end with a name that cannot be written.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "foldproof/base.h"

namespace foldproof {

class FileArguments {
 public:
  /// What stands behind the name of an output.
  enum class Output : std::uint8_t {
    File,
    Motion,      ///< .npz, .obj with a .pc2 beside it, .ply.
    Numbered,    ///< %d or %04d in the name stands for any number.
    Collection,  ///< A file, and a directory of its name without the extension.
    Directory,   ///< Is made where it is missing.
  };
  /// What stands behind the name of an input.
  enum class Input : std::uint8_t {
    Motion,   ///< A file, a glTF and its buffers, a directory or a glob of meshes.
    Library,  ///< A directory with motions anywhere below.
  };

  /// Notes an option, which must live as long as this, and gives it back.
  CLI::Option* reads(CLI::Option* option, Input input = Input::Motion);
  CLI::Option* writes(CLI::Option* option, Output output = Output::File);

  /// To be called when the command line was parsed. Error: an input or output has no name; an output is a
  /// directory (or is none where it must be one), lies in a directory that is not there or not writable, has
  /// an extension that is not written, or is the same file as an input or another output: also under another
  /// name, by a link, as a member of a directory of frames, as a buffer of a glTF. The contents of inputs are
  /// not looked at, but for the names of a glTF's buffers.
  Result<void> check() const;

 private:
  struct Read {
    const CLI::Option* option;
    Input input;
  };
  struct Write {
    const CLI::Option* option;
    Output output;
  };
  std::vector<Read> inputs_;
  std::vector<Write> outputs_;
};

}  // namespace foldproof
