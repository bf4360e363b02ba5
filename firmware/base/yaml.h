// Reading settings from YAML so that every mistake becomes one line: file, key, value, what is allowed.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "firmware/base/result.h"

namespace adit::base {

/// What a number may be.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// `text` between double quotes, escaped, so that every YAML reader reads the same text back.
std::string Quoted(const std::string& text);

/// A place in a YAML document. Ask for keys one after the other; the first mistake is kept, later questions
/// return their fallback. Finish() returns that mistake, and refuses keys that nobody asked for. Not for the
/// hot path.
class YamlReader {
 public:
  /// Opens a file of at most 1 MiB. Declines with kNotFound (also for a folder) or kMalformed (also when
  /// empty, binary, or several documents).
  static Result<YamlReader> OpenFile(const std::string& path);
  /// Reads text; `name` stands for the file in messages.
  static Result<YamlReader> OpenText(const std::string& text, const std::string& name);

  bool Has(const std::string& key) const;
  double Number(const std::string& key, Range range = {});
  double NumberOr(const std::string& key, double fallback, Range range = {});
  long Integer(const std::string& key, Range range = {});
  long IntegerOr(const std::string& key, long fallback, Range range = {});
  bool BoolOr(const std::string& key, bool fallback);
  std::string Text(const std::string& key);
  std::string TextOr(const std::string& key, const std::string& fallback);
  /// One of `allowed`.
  std::string Choice(const std::string& key, const std::vector<std::string>& allowed);
  std::string ChoiceOr(const std::string& key, const std::string& fallback,
                       const std::vector<std::string>& allowed);
  /// A list of numbers of length `count` (0: any length).
  std::vector<double> Numbers(const std::string& key, std::size_t count, Range range = {});
  /// A list of rows, each of `columns` numbers, row after row.
  std::vector<double> Matrix(const std::string& key, std::size_t rows, std::size_t columns);
  std::vector<std::string> TextsOr(const std::string& key, const std::vector<std::string>& fallback);

  /// The map below `key`. Its mistakes count here; there is no need to Finish it on its own.
  YamlReader Child(const std::string& key);
  /// The maps of the list below `key`; empty if the key is absent.
  std::vector<YamlReader> Items(const std::string& key);
  /// The keys of this map, in file order.
  std::vector<std::string> Keys() const;
  /// Accepts `key` unread (a foreign key in a file that other tools share).
  void Ignore(const std::string& key);

  /// Records a mistake of the caller's own finding at `key` (kOutOfRange).
  void Refuse(const std::string& key, const std::string& detail);
  /// True while nothing is wrong.
  bool Ok() const;
  /// "file" or "file: key.path"
  std::string Where(const std::string& key = "") const;
  /// The first mistake, or an unknown key, or done.
  Result<void> Finish();

 private:
  struct Document;
  struct Node;
  YamlReader(std::shared_ptr<Document> document, std::shared_ptr<Node> node);
  std::shared_ptr<Document> document_;
  std::shared_ptr<Node> node_;
};

}  // namespace adit::base
