/// Text as Windows has it, for the other files here.
#pragma once

#include <string>
#include <system_error>

namespace foldproof::system {

/// The UTF-16 of UTF-8 text.
std::wstring wide(const std::string& text);
std::string narrow(const wchar_t* text);

/// Does nothing; whoever calls it is linked with what makes paths of UTF-8 text (path_text.cpp).
void take_utf8_in_paths();

/// Of an error of Windows; one of the standard's where it has the same.
std::error_code windows_error(unsigned long code);

}  // namespace foldproof::system
