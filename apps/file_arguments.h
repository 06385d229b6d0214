/// Checks the files of a command line before work starts: outputs must not overwrite inputs, and must be
/// writable.
#pragma once

#include <filesystem>
#include <vector>

#include "command_line.h"

namespace foldproof {

class FileArguments {
 public:
  /// What an output's name refers to.
  enum class Output : std::uint8_t {
    File,
    Text,        ///< A file, or "-": standard output.
    Motion,      ///< .npz, .obj with a .pc2 or .mdd beside it, .ply; %d or %04d in the name as below.
    Numbered,    ///< %d or %04d in the name is replaced by numbers.
    Collection,  ///< A file, and a directory of its name without the extension.
  };
  /// What an input's name refers to.
  enum class Input : std::uint8_t {
    Motion,   ///< A file, a glTF and its buffers, a directory or a glob of meshes.
    Library,  ///< A directory with motions anywhere below.
  };

  /// Registers an option, which must outlive this, and returns it.
  Option reads(Option option, Input input = Input::Motion);
  /// `endings`: those that the file's name may have; by default, all but those of motions. A name without an
  /// ending is always allowed. Of a motion: those that are allowed besides.
  Option writes(Option option, Output output = Output::File, std::vector<std::string> endings = {});

  /// Call it after the command line was parsed. Error: an input or output has an empty name; an output is a
  /// directory, is in a directory that does not exist or is not writable, has an ending that it may not have,
  /// or is the same file as an input or another output, also under another name, by a link, as a member of a
  /// directory of frames, as a buffer of a glTF, in the directory of a collection, or by a number in its
  /// name; or it would be a frame of an input the next time. Of inputs, only the buffer names of a glTF are
  /// read. If an output is standard output, print_output prints on standard error from then on.
  Result<void> check() const;

  /// All files that the inputs refer to, whether they exist or not.
  std::vector<std::filesystem::path> files_read() const;

 private:
  struct Read {
    Option option;
    Input input;
  };
  struct Write {
    Option option;
    Output output;
    std::vector<std::string> endings;
  };
  std::vector<Read> inputs_;
  std::vector<Write> outputs_;
};

}  // namespace foldproof
