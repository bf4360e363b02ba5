// A georeference, as a page.
#pragma once

#include "host/georef_report.h"
#include "host/report_page.h"

namespace adit::host {

/// The points with residuals and tests, the plan with residual vectors, residuals with each point taking part
/// and left out; the full text of FormatGeorefReport stays what is signed.
ReportPage MakeGeorefPage(const Georeferencing& result, const GeorefOrigin& origin);

}  // namespace adit::host
