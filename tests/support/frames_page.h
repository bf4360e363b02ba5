// The numbers of firmware/FRAMES.md.
#pragma once

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace adit::tests {

/// The lines `name = numbers` of the page.
inline std::map<std::string, std::vector<double>> ReadFramesPage() {
  std::map<std::string, std::vector<double>> numbers;
  std::ifstream page("firmware/FRAMES.md");
  for (std::string line; std::getline(page, line);) {
    std::istringstream text(line);
    std::string name, equals;
    double number = 0;
    if (!(text >> name >> equals) || equals != "=") continue;
    while (text >> number) numbers[name].push_back(number);
  }
  return numbers;
}

}  // namespace adit::tests
