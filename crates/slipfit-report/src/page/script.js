// Values at once under the pointer. Without this script the dots say theirs by their titles.
(function () {
  "use strict";
  var box = document.createElement("div");
  box.id = "value";
  box.hidden = true;
  document.body.appendChild(box);
  function told(text, place, size, at) {
    var part = text.split(";"), low = Number(part[1]), high = Number(part[2]), name = part.slice(3).join(";");
    var share = (at - place) / size, unit = "", cut = name.lastIndexOf(" [");
    if (part[0] === "names") { return ""; }
    if (cut > 0) { unit = " " + name.slice(cut + 2, -1); name = name.slice(0, cut); }
    var value = part[0] === "log" ? low * Math.pow(high / low, share) : low + share * (high - low);
    return name + " " + Number(value.toPrecision(4)) + unit;
  }
  document.querySelectorAll("figure svg").forEach(function (svg) {
    var dots = [];
    svg.querySelectorAll("circle").forEach(function (dot) {
      var title = dot.querySelector("title");
      if (title) {
        dots.push([Number(dot.getAttribute("cx")), Number(dot.getAttribute("cy")), title.textContent]);
        title.remove();
      }
    });
    var frame = svg.querySelector(".frame");
    function show(event) {
      var matrix = svg.getScreenCTM();
      if (!matrix || !frame) { return; }
      var at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
      var near = 196, text = "";
      dots.forEach(function (dot) {
        var away = Math.pow(dot[0] - at.x, 2) + Math.pow(dot[1] - at.y, 2);
        if (near > away) { near = away; text = dot[2]; }
      });
      if (!text) {
        var b = ["x", "y", "width", "height"].map(function (k) { return Number(frame.getAttribute(k)); });
        if (b[0] > at.x || b[1] > at.y || at.x > b[0] + b[2] || at.y > b[1] + b[3]) { box.hidden = true; return; }
        text = [told(frame.dataset.x, b[0], b[2], at.x), told(frame.dataset.y, b[1] + b[3], -b[3], at.y)]
          .filter(Boolean).join("\n");
      }
      box.textContent = text;
      box.hidden = !text;
      var wide = box.offsetWidth, left = event.clientX + 14;
      box.style.left = (left + wide > window.innerWidth ? event.clientX - wide - 14 : left) + "px";
      box.style.top = Math.max(4, event.clientY - box.offsetHeight - 10) + "px";
    }
    svg.addEventListener("pointermove", show);
    svg.addEventListener("pointerdown", show);
    svg.addEventListener("pointerleave", function () { box.hidden = true; });
  });
})();
