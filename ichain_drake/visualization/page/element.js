// Adds an element of a tag to a parent, with a class and text where they are given, and gives it back.
const ichainMake = (parent, tag, className, text) => {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text !== undefined) element.textContent = text;
  parent.appendChild(element);
  return element;
};
