// The weights of Sphinx, but guides before the reference and the list of changes where they match alike.
var Scorer = {
  score: ([page, , , , score]) =>
    score - (page.startsWith("api/") ? 7 : page === "changes" ? 8 : page.startsWith("auto_gallery/") ? 3 : 0),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
