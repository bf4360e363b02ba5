#include "firmware/base/yaml.h"

#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "firmware/base/yaml_document.h"

namespace adit::base {
namespace {

std::string Wanted(Range range) {
  std::ostringstream text;
  if (std::isfinite(range.min) && std::isfinite(range.max)) {
    text << "a number from " << range.min << " to " << range.max;
  } else if (std::isfinite(range.min)) {
    text << "a number of at least " << range.min;
  } else if (std::isfinite(range.max)) {
    text << "a number of at most " << range.max;
  } else {
    text << "a number";
  }
  return text.str();
}

std::string Join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string KeyOf(const YAML::Node& key) { return key.IsScalar() ? Printable(key.Scalar()) : Show(key); }

std::string At(const std::string& key, std::size_t index) { return key + "[" + std::to_string(index) + "]"; }

bool ParseNumber(const YAML::Node& node, double& out) {
  if (!node.IsScalar()) return false;
  double value = 0;
  if (!YAML::convert<double>::decode(node, value) || !std::isfinite(value)) return false;
  out = value;
  return true;
}

}  // namespace

std::string Quoted(const std::string& text) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (byte < 0x20 || byte == 0x7F) {
      quoted += {'\\', 'x', kHex[byte / 16], kHex[byte % 16]};
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

struct YamlReader::Document {
  std::string name;
  std::optional<Error> error;
  std::vector<std::shared_ptr<Node>> nodes;  // all maps that were opened, for the search of unknown keys
};

struct YamlReader::Node {
  YAML::Node yaml;
  std::string path;
  std::set<std::string> asked;
};

YamlReader::YamlReader(std::shared_ptr<Document> document, std::shared_ptr<Node> node)
    : document_(std::move(document)), node_(std::move(node)) {
  document_->nodes.push_back(node_);
  // YAML forbids a key twice in a map; the library takes the first and is silent.
  std::set<std::string> keys;
  for (const auto& entry : node_->yaml) {
    const std::string key = KeyOf(entry.first);
    if (!keys.insert(key).second) Refuse(key, "stands there twice; give it once");
  }
}

Result<YamlReader> YamlReader::OpenFile(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return Error{ErrorCode::kNotFound, path, "is a folder; give the path of a YAML file"};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, path, std::string("cannot be read: ") + std::strerror(errno)};
  // One more than allowed, so that a device that never ends is no trap.
  std::string text(kLargestYamlBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return Error{ErrorCode::kUnavailable, path, "cannot be read: the device reports an error"};
  text.resize(static_cast<std::size_t>(file.gcount()));
  return OpenText(text, path);
}

Result<YamlReader> YamlReader::OpenText(const std::string& text, const std::string& name) {
  Result<YAML::Node> parsed = ParseYamlMap(text, name);
  if (!parsed) return parsed.error();
  auto document = std::make_shared<Document>();
  document->name = name;
  auto root = std::make_shared<Node>();
  root->yaml = *parsed;
  return YamlReader(document, root);
}

std::string YamlReader::Where(const std::string& key) const {
  const std::string path = node_->path.empty() || key.empty() ? node_->path + key : node_->path + "." + key;
  return path.empty() ? document_->name : document_->name + ": " + path;
}

bool YamlReader::Ok() const { return !document_->error.has_value(); }

void YamlReader::Refuse(const std::string& key, const std::string& detail) {
  if (Ok()) document_->error = Error{ErrorCode::kOutOfRange, Where(key), detail};
}

void YamlReader::Ignore(const std::string& key) { node_->asked.insert(key); }

bool YamlReader::Has(const std::string& key) const {
  return node_->yaml.IsMap() && static_cast<bool>(std::as_const(node_->yaml)[key]);
}

std::vector<std::string> YamlReader::Keys() const {
  std::vector<std::string> keys;
  if (node_->yaml.IsMap()) {
    for (const auto& entry : node_->yaml) keys.push_back(KeyOf(entry.first));
  }
  return keys;
}

double YamlReader::Number(const std::string& key, Range range) {
  node_->asked.insert(key);
  if (!Has(key)) {
    Refuse(key, "is missing; it must be " + Wanted(range));
    return 0;
  }
  const YAML::Node value = std::as_const(node_->yaml)[key];
  double number = 0;
  if (!ParseNumber(value, number) || number < range.min || number > range.max) {
    Refuse(key, "is " + Show(value) + "; it must be " + Wanted(range));
    return 0;
  }
  return number;
}

double YamlReader::NumberOr(const std::string& key, double fallback, Range range) {
  node_->asked.insert(key);
  return Has(key) ? Number(key, range) : fallback;
}

long YamlReader::Integer(const std::string& key, Range range) {
  const double number = Number(key, range);
  constexpr double kExact = 9007199254740992.0;  // 2^53: beyond it a double skips integers
  if (Ok() && (number != std::floor(number) || std::abs(number) > kExact)) {
    Refuse(key, "is " + Show(std::as_const(node_->yaml)[key]) + "; it must be a whole number");
    return 0;
  }
  return Ok() ? static_cast<long>(number) : 0;
}

long YamlReader::IntegerOr(const std::string& key, long fallback, Range range) {
  node_->asked.insert(key);
  return Has(key) ? Integer(key, range) : fallback;
}

bool YamlReader::BoolOr(const std::string& key, bool fallback) {
  node_->asked.insert(key);
  if (!Has(key)) return fallback;
  bool value = fallback;
  const YAML::Node node = std::as_const(node_->yaml)[key];
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) {
    Refuse(key, "is " + Show(node) + "; it must be true or false");
  }
  return value;
}

std::string YamlReader::Text(const std::string& key) {
  node_->asked.insert(key);
  const YAML::Node value = std::as_const(node_->yaml)[key];
  if (!Has(key) || !value.IsScalar() || value.Scalar().empty()) {
    Refuse(key, Has(key) ? "is " + Show(value) + "; it must be a text" : "is missing; it must be a text");
    return "";
  }
  return value.Scalar();
}

std::string YamlReader::TextOr(const std::string& key, const std::string& fallback) {
  node_->asked.insert(key);
  return Has(key) ? Text(key) : fallback;
}

std::string YamlReader::Choice(const std::string& key, const std::vector<std::string>& allowed) {
  if (!Has(key)) Refuse(key, "is missing; it must be one of: " + Join(allowed));
  const std::string value = Text(key);
  for (const std::string& word : allowed) {
    if (value == word) return value;
  }
  Refuse(key, "is '" + Printable(value) + "'; it must be one of: " + Join(allowed));
  return allowed.front();
}

std::string YamlReader::ChoiceOr(const std::string& key, const std::string& fallback,
                                 const std::vector<std::string>& allowed) {
  node_->asked.insert(key);
  return Has(key) ? Choice(key, allowed) : fallback;
}

std::vector<double> YamlReader::Numbers(const std::string& key, std::size_t count, Range range) {
  node_->asked.insert(key);
  const YAML::Node list = std::as_const(node_->yaml)[key];
  const std::string wanted =
      (count == 0 ? "a list, each " : "a list of " + std::to_string(count) + ", each ") + Wanted(range);
  std::vector<double> numbers;
  if (!Has(key) || !list.IsSequence() || (count != 0 && list.size() != count)) {
    Refuse(key, (Has(key) ? "is " + Show(list) : std::string("is missing")) + "; it must be " + wanted);
    return std::vector<double>(count, 0.0);
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    double number = 0;
    if (!ParseNumber(list[i], number) || number < range.min || number > range.max) {
      Refuse(At(key, i), "is " + Show(list[i]) + "; it must be " + Wanted(range));
    }
    numbers.push_back(number);
  }
  return numbers;
}

std::vector<double> YamlReader::Matrix(const std::string& key, std::size_t rows, std::size_t columns) {
  node_->asked.insert(key);
  std::vector<double> numbers(rows * columns, 0.0);
  const YAML::Node list = std::as_const(node_->yaml)[key];
  const std::string wanted = std::to_string(rows) + " rows of " + std::to_string(columns) + " numbers";
  if (!Has(key) || !list.IsSequence() || list.size() != rows) {
    Refuse(key, (Has(key) ? "is " + Show(list) : std::string("is missing")) + "; it must be " + wanted);
    return numbers;
  }
  for (std::size_t r = 0; r < rows; ++r) {
    if (!list[r].IsSequence() || list[r].size() != columns) {
      Refuse(At(key, r), "is " + Show(list[r]) + "; it must be one of " + wanted);
      return numbers;
    }
    for (std::size_t c = 0; c < columns; ++c) {
      if (!ParseNumber(list[r][c], numbers[r * columns + c]))
        Refuse(At(At(key, r), c), "is " + Show(list[r][c]) + "; it must be a number");
    }
  }
  return numbers;
}

std::vector<std::string> YamlReader::TextsOr(const std::string& key,
                                             const std::vector<std::string>& fallback) {
  node_->asked.insert(key);
  if (!Has(key)) return fallback;
  const YAML::Node list = std::as_const(node_->yaml)[key];
  std::vector<std::string> texts;
  if (!list.IsSequence()) Refuse(key, "is " + Show(list) + "; it must be a list of texts");
  for (std::size_t i = 0; list.IsSequence() && i < list.size(); ++i) {
    if (!list[i].IsScalar())
      Refuse(At(key, i), "is " + Show(list[i]) + "; it must be a text");
    else
      texts.push_back(list[i].Scalar());
  }
  return texts;
}

YamlReader YamlReader::Child(const std::string& key) {
  node_->asked.insert(key);
  auto node = std::make_shared<Node>();
  node->path = node_->path.empty() ? key : node_->path + "." + key;
  const YAML::Node value = std::as_const(node_->yaml)[key];
  if (Has(key) && value.IsMap()) {
    node->yaml = value;
  } else {
    Refuse(key, (Has(key) ? "is " + Show(value) : std::string("is missing")) + "; it must be a map");
    node->yaml = YAML::Node(YAML::NodeType::Map);
  }
  return YamlReader(document_, node);
}

std::vector<YamlReader> YamlReader::Items(const std::string& key) {
  node_->asked.insert(key);
  std::vector<YamlReader> items;
  if (!Has(key)) return items;
  const YAML::Node list = std::as_const(node_->yaml)[key];
  if (!list.IsSequence()) Refuse(key, "is " + Show(list) + "; it must be a list of maps");
  for (std::size_t i = 0; list.IsSequence() && i < list.size(); ++i) {
    auto node = std::make_shared<Node>();
    const std::string name = At(key, i);
    node->path = node_->path.empty() ? name : node_->path + "." + name;
    const bool is_map = list[i].IsMap();
    if (!is_map) Refuse(name, "is " + Show(list[i]) + "; it must be a map");
    // An empty map in its place: the library throws when asked for a key of a text.
    node->yaml = is_map ? list[i] : YAML::Node(YAML::NodeType::Map);
    items.push_back(YamlReader(document_, node));
  }
  return items;
}

Result<void> YamlReader::Finish() {
  if (!Ok()) return *document_->error;
  for (const auto& node : document_->nodes) {
    if (!node->yaml.IsMap()) continue;
    for (const auto& entry : node->yaml) {
      const std::string key = KeyOf(entry.first);
      if (node->asked.count(key) == 0) {
        const std::string path = node->path.empty() ? key : node->path + "." + key;
        std::vector<std::string> known(node->asked.begin(), node->asked.end());
        return Error{ErrorCode::kMalformed, document_->name + ": " + path,
                     "is not known here; known: " + Join(known)};
      }
    }
  }
  return {};
}

}  // namespace adit::base
